// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode/writer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "program/writers/rounded_arc.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A shorter chord's direction would be that of its rounding, and a short arc a full circle.
constexpr double kShortest_mm = 1e-4;
/// An arc that bulges less than this is a line.
constexpr double kFlat_mm = 1e-5;
/// The radii of an arc's ends differ by rounding alone.
constexpr double kOneRadius_mm = 1e-3;
/// LinuxCNC backs off that much in G83 and G73.
constexpr double kPeckClearance_mm = 0.254;
/// More to a hole is a stroke that was mistyped.
constexpr std::int64_t kMaxPeckStrokes = 1000;

}  // namespace

GcodeWriter::GcodeWriter(ByteSink& bytes, ProgramWriterOptions options, GcodeSetting setting)
    : ProgramWriter(bytes, std::nullopt, std::move(options)),
      setting_(std::move(setting)),
      wording_(wording_of(setting_.flavour.value_or(GcodeFlavour::LinuxCnc))) {
}

/// XY plane, mm, no compensation, the first work zero, exact path, no cycle, absolute places,
/// relative centres, mm/min, and cycles go back up to where they began.
void GcodeWriter::begin(const ProgramInfo& info) {
  ProgramWriter::begin(info);
  lose_tool_table();
  for (const std::string& words : options().comments) comment(words);
  line(wording_.head);
}

void GcodeWriter::put(const Operation& operation) {
  note_place(operation);
  std::visit([this](const auto& what) { write(what); }, operation.what);
  flush_if_large();
}

void GcodeWriter::end() {
  if (!has_ended_) park({});
  if (!has_ended_ && !wording_.end.empty()) line(wording_.end);
}

// --- tools -------------------------------------------------------------------------------------

void GcodeWriter::write(const ToolChange& change) {
  take(change.tool);
}

/// A tool change may have moved it anywhere.
void GcodeWriter::take(const Tool& tool) {
  park({});
  tool_ = tool;
  work_ = setting_.work_of(tool);
  const std::string size =
      tool.diameter ? fmt::format("{:.6g} mm", tool.diameter->in_mm()) : std::string();
  if (wording_.changes_tools) {
    line(fmt::format("T{} M6{}{}", tool.number, size.empty() ? "" : " ; ", size));
    if (setting_.has_length_offset) line(tool.number == 0 ? "G49" : "G43");
  } else {
    say_message(fmt::format("tool T{}{}{}", tool.number, size.empty() ? "" : ", ", size));
    line("M0");
  }
  height_ = Height::Unknown;
  told_.reset();
  forget_feed();
}

void GcodeWriter::write(const ToolRate& rate) {
  if (rate.infeed) tool_.infeed = rate.infeed;
  if (rate.retract) tool_.retract = rate.retract;
  work_ = setting_.work_of(tool_);
}

void GcodeWriter::write(const Autocalibration&) {
  lose("the camera's own calibration (G39)");
}

// --- drilling ----------------------------------------------------------------------------------

void GcodeWriter::write(const Drill& drill) {
  const Place at = place_of(drill.actual);
  at_ = at;
  const auto z = working_z(drill.cut, work_.drill_z, tool_.depth_offset, "drill_z_mm");
  const auto feed = infeed();
  if (!start_spindle() || !z || !feed) return;
  const bool pecks = pecking_ != Pecking::Off && work_.peck;
  if (pecking_ != Pecking::Off && !pecks) {
    lose_once(fmt::format("peck drilling of T{}, without peck_mm in [gcode],", tool_.number));
  }
  const bool has_cycle = wording_.has_cycles && (pecks || !work_.retract);
  if (has_cycle) return drill_cycle(at, *z, *feed);
  return pecks ? peck_moves(at, *z, *feed) : drill_moves(at, *z, *feed);
}

std::string_view GcodeWriter::cycle_code() {
  if (pecking_ == Pecking::Off || !work_.peck) return "G81";
  if (work_.retract) {
    lose_once(fmt::format("the retract rate of T{} in a peck cycle", tool_.number));
  }
  return pecking_ == Pecking::Retracting ? "G83" : "G73";
}

/// Behind the series' first hole the places are enough, until something changes.
void GcodeWriter::drill_cycle(const Place& at, Steps z, Feed infeed) {
  rise();
  std::string cycle(cycle_code());
  const bool pecks = cycle != "G81";
  const std::string depth = word('Z', z) + ' ' + word('R', steps(rapid_limit().in_mm()));
  const std::string stroke = pecks ? ' ' + word('Q', steps(work_.peck->in_mm())) : "";
  const std::string wanted = fmt::format("{} {}{} {}", cycle, depth, stroke, infeed.in_mm_s());
  if (wanted == cycle_) {
    line(words(at));
  } else {
    say_move(cycle, words(at) + ' ' + depth + stroke, infeed);
    cycle_ = wanted;
  }
  told_ = at;
}

/// A cycle would go up rapidly.
void GcodeWriter::drill_moves(const Place& at, Steps z, Feed infeed) {
  go_to(at);
  go_down(z, infeed);
  go_up(steps(setting_.safe_z.in_mm()));
}

/// What G83 and G73 do by themselves.
void GcodeWriter::peck_moves(const Place& at, Steps z, Feed infeed) {
  const Steps from = steps(rapid_limit().in_mm());
  const Steps stroke = std::max<Steps>(1, steps(work_.peck->in_mm()));
  const Steps clearance = steps(kPeckClearance_mm);
  if ((from - z) / stroke >= kMaxPeckStrokes) {
    return refuse(
        fmt::format("a hole of T{} in more than {} strokes", tool_.number, kMaxPeckStrokes),
        "a larger peck_mm in [gcode]");
  }
  go_to(at);
  for (Steps bottom = from - stroke; bottom > z; bottom -= stroke) {
    go_down(bottom, infeed);
    const Steps again = std::min(from, bottom + clearance);
    if (pecking_ == Pecking::Pulsing) {
      go_up(again);
    } else {
      go_up(from);
      if (again < from) say_rapid(word('Z', again));
    }
    height_ = Height::Down;
  }
  go_down(z, infeed);
  go_up(steps(setting_.safe_z.in_mm()));
}

void GcodeWriter::go_down(Steps z, Feed infeed) {
  if (height_ == Height::Safe && setting_.approach_z && *setting_.approach_z < setting_.safe_z) {
    say_rapid(word('Z', steps(setting_.approach_z->in_mm())));
  }
  say_move("G1", word('Z', z), infeed);
  height_ = Height::Down;
  told_z_ = z;
}

/// Within the hole, or out of it.
void GcodeWriter::go_up(Steps z) {
  if (work_.retract) {
    say_move("G1", word('Z', z), *work_.retract);
  } else {
    say_rapid(word('Z', z));
  }
  if (z < steps(setting_.safe_z.in_mm())) return;
  height_ = Height::Safe;
  told_z_.reset();
}

void GcodeWriter::write(const Slot&) {
  refuse("a drilled slot left whole", "--slots expand");
}

void GcodeWriter::write(const StepSlot&) {
  refuse("a slot in deepening passes left whole", "--slots expand");
}

// --- routing -----------------------------------------------------------------------------------

void GcodeWriter::write(const RapidMove& move) {
  at_ = place_of(move.actual);
  go_to(*at_);
}

/// A further one inside a contour goes down or up where the tool stands.
void GcodeWriter::write(const Plunge& plunge) {
  if (plunge.kind == PlungeKind::Contouring) {
    refuse("M14, which lowers the router to a depth that follows the material", "M15");
  }
  const std::optional<Length> offset =
      plunge.depth_offset ? plunge.depth_offset : tool_.depth_offset;
  const auto z = working_z(plunge.cut, work_.rout_z, offset, "rout_z_mm");
  const auto feed = infeed();
  if (!start_spindle() || !z || !feed) return;
  if (!at_) {
    return fail({Code::Internal, place(), "plunge before the first place", "a move before it"});
  }
  if (height_ != Height::Down) go_to(*at_);
  go_down(*z, *feed);
}

/// A move that says no depth keeps the one that the tool was lowered to.
void GcodeWriter::write(const Rout& rout) {
  const Place to = place_of(rout.actual);
  const auto feed = routing_feed(rout);
  std::optional<Steps> z = told_z_;
  if (rout.cut.z || rout.cut.is_controlled()) {
    z = working_z(rout.cut, work_.rout_z, tool_.depth_offset, "rout_z_mm");
  }
  at_ = to;
  if (!feed || !z || height_ != Height::Down || !told_) {
    // A contour is left out only where a diagnostic has the reason.
    if (losses().has_errors()) return;
    return fail({Code::Internal, place(), "a contour without a plunge", "a plunge before it"});
  }
  const std::string z_word = z != told_z_ ? ' ' + word('Z', *z) : "";
  if (to == *told_ && z_word.empty()) return;
  const bool is_line = rout.kind == RoutKind::Line || !write_arc(rout, to, *feed, z_word);
  if (is_line) say_move("G1", words(to) + z_word, *feed);
  told_ = to;
  told_z_ = z;
}

/// False for an arc that is written as a line. Rounded ends lie on the circle: its centre is moved
/// onto their bisector.
bool GcodeWriter::write_arc(const Rout& rout, const Place& to, Feed feed, std::string_view z_word) {
  const Eigen::Vector2d from_mm = in_mm(*told_), to_mm = in_mm(to);
  const Eigen::Vector2d center_mm = from_zero_mm(rout.center);
  const Eigen::Vector2d chord_mm = to_mm - from_mm;
  if (!(chord_mm.norm() > kShortest_mm)) return false;
  const double mismatch_mm = (from_mm - center_mm).norm() - (to_mm - center_mm).norm();
  if (!(std::abs(mismatch_mm) < kOneRadius_mm)) {
    fail({Code::Internal,
          place(),
          fmt::format("an arc whose radius changes by {:.4f} mm", mismatch_mm),
          "one radius"});
    return true;
  }
  const Eigen::Vector2d on_bisector_mm = center_of_rounded(from_mm, to_mm, center_mm);
  const double radius_mm = (from_mm - on_bisector_mm).norm();
  const double bulge_mm = chord_mm.squaredNorm() / (8 * radius_mm);  // at least
  if (bulge_mm < kFlat_mm) return false;
  const Eigen::Vector2d offset_mm = on_bisector_mm - from_mm;
  say_move(rout.kind == RoutKind::Clockwise ? "G2" : "G3",
           fmt::format("{}{} {} {}",
                       words(to),
                       z_word,
                       word('I', steps(offset_mm.x())),
                       word('J', steps(offset_mm.y()))),
           feed);
  return true;
}

/// The tool may be up already: M16 and M17 may stand anywhere.
void GcodeWriter::write(const Retract& retract) {
  if (retract.with_clamping) lose_once("clamping while the router is raised (M16)");
  if (height_ == Height::Down) go_up(steps(setting_.safe_z.in_mm()));
}

/// LinuxCNC's compensation needs a straight entry longer than the radius, which programs of boards
/// do not have.
void GcodeWriter::write(const Compensation& compensation) {
  if (compensation.side == CompensationSide::Off) return;
  refuse("cutter compensation by the control (G41, G42)", "the way of the cutter's centre");
}

void GcodeWriter::write(const Dwell& dwell) {
  leave_cycle();
  line(fmt::format("{}{:.6g}", wording_.dwell, dwell.duration.in_s()));
}

/// Coordinates count from the zero that holds when the program begins.
void GcodeWriter::write(const ZeroSet&) {
}

}  // namespace panelcal
