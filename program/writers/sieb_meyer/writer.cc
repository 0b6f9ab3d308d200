// SPDX-License-Identifier: Apache-2.0
#include "program/writers/sieb_meyer/writer.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "program/writers/rounded_arc.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Source SIEB & MEYER CNC 8x.00 Command Set, A.7.1
constexpr std::size_t kMostCommentCharacters = 64;

/// A centre is good to 0.05 um with these, and the line does not grow too long.
constexpr int kShortDecimals = 4;
constexpr std::size_t kLongArc = 50;

/// Diameters in inches and in millimetres.
constexpr double kSame_um = 0.01;

void append_comment(std::string& out, std::string comment) {
  // Two percent signs would begin the program.
  comment = printable(comment);
  std::ranges::replace(comment, '%', '?');
  for (std::size_t at = 0; at < comment.size(); at += kMostCommentCharacters) {
    out += comment.substr(at, kMostCommentCharacters);
    out += '\n';
  }
}

}  // namespace

SiebMeyerWriter::SiebMeyerWriter(ByteSink& bytes, ProgramWriterOptions options)
    : ProgramWriter(bytes, Dialect::SiebMeyer, std::move(options)) {
}

void SiebMeyerWriter::begin(const ProgramInfo& info) {
  ProgramWriter::begin(info);
  tools_ = info.tools;
  for (const std::string& comment : options().comments) append_comment(text(), comment);
  line("%%5000");
}

void SiebMeyerWriter::put(const Operation& operation) {
  note_place(operation);
  if (!states_control_) {
    // A source that begins with its axes does not need those of the configuration before them.
    const auto* setting = std::get_if<Setting>(&operation.what);
    if (setting == nullptr || is_foreign() || !setting->text.starts_with("M49,FV")) {
      state_control(info().axis_version);
    }
  }
  if (has_place_words() && !is_of(place_words_.line)) settle_place_words();
  std::visit([this](const auto& what) { write(what); }, operation.what);
  flush_if_large();
}

void SiebMeyerWriter::end() {
  if (!states_control_) state_control(info().axis_version);
  settle_place_words();
  say_tool();
  finish_line();
  if (depth_.is_slm) line("G70");
  if (probing_tool_ == "T0") lose_once("putting the tool away (T0)");
  write_tool_table();
}

// --- tools -------------------------------------------------------------------------------------

void SiebMeyerWriter::write(const ToolChange& change) {
  if (change.tool.number == 0) {
    pending_tool_.reset();
    if (!is_foreign()) {
      probing_tool_ = "T0";
      return;
    }
    return lose_once("putting the tool away (T0)");
  }
  if (std::exchange(probing_tool_, {}) == "T0") lose_once("putting the tool away (T0)");
  note_tool(change.tool);
  tool_ = change.tool.number;
  pending_tool_ = tool_;
}

void SiebMeyerWriter::write(const ToolRate& rate) {
  Tool& tool = tools_[rate.tool];
  tool.number = rate.tool;
  const bool contradicts = (rate.infeed && tool.infeed && *rate.infeed != *tool.infeed) ||
                           (rate.retract && tool.retract && *rate.retract != *tool.retract);
  if (contradicts) return lose(fmt::format("another rate of tool {}", rate.tool));
  if (rate.infeed) tool.infeed = rate.infeed;
  if (rate.retract) tool.retract = rate.retract;
}

// --- drilling ----------------------------------------------------------------------------------

/// The line stays open.
void SiebMeyerWriter::drill_line(const Eigen::Vector2d& at_mm,
                                 const DepthOfCut& cut,
                                 std::string_view command) {
  const DepthOfCut* const told = told_cut(cut);
  if (told) say_surface_line(*told);
  open_line(at_mm);
  line_ += command;
  if (told) say_depth(*told, false);
}

void SiebMeyerWriter::write(const Drill& drill) {
  note_work();
  drill_line(drill.commanded.in_mm(), drill.cut, "");
}

void SiebMeyerWriter::write(const Slot& slot) {
  note_work();
  drill_line(slot.start.commanded.in_mm(), slot.cut, "G85");
  open_line(slot.end.commanded.in_mm());
}

void SiebMeyerWriter::write(const StepSlot&) {
  refuse("a slot in deepening passes (G87)", "a slot routed in one pass, or one drilled (G85)");
}

void SiebMeyerWriter::write(const Autocalibration&) {
  lose("the camera's own calibration (G39)");
}

// --- routing -----------------------------------------------------------------------------------

/// A second T0 line at the same place would only cost time, but words of a line for its place must
/// not come to the line before: M20 there would stop ahead of the contour's end, the cutter down.
void SiebMeyerWriter::write(const RapidMove& move) {
  note_work();
  const Eigen::Vector2d to_mm = move.commanded.in_mm();
  if (up_at_ == steps(to_mm) && !pending_tool_) {
    const bool has_words = place_words_.may_stop || place_words_.has_output;
    if (!has_words) return;
    if (is_tool_up_line_ && is_of(line_source_)) return say_place_words();
  }
  tool_up_line(to_mm);
}

/// "Every routing contour is started and finished by the T0 commands" (3.4): where the cutter is
/// lowered again, be it at the place where a contour ends, a T0 line of its own begins the next.
/// The first rout line behind it lowers the cutter, but a ramp's begin has to be said before.
void SiebMeyerWriter::write(const Plunge& plunge) {
  note_work();
  if (plunge.kind == PlungeKind::Contouring && !plunge.cut.is_controlled()) {
    refuse("M14, which lowers the router to a depth that follows the material", "M15");
  }
  if (plunge.depth_offset) refuse("a pass of a step slot", "step slots left whole");
  const DepthOfCut* const told = told_cut(plunge.cut);
  if (is_down_ && has_routed_) {
    tool_up_line(at_mm_);
    ends_contour_ = true;
  }
  if (told) say_surface_line_of_contour(*told);
  is_down_ = true;
  has_routed_ = false;
  const bool says_depth =
      plunge.cut.z || plunge.cut.is_controlled() || depth_.is_controlled != false;
  if (!up_at_ || pending_tool_ || ends_contour_ || (says_depth && !is_tool_up_line_)) {
    tool_up_line(at_mm_);
  }
  if (told) say_depth(*told, false);
}

/// I and J lead from the centre to the start (SIEB & MEYER CNC 8x.00 Command Set, I). The same
/// coordinates twice running would stop the control.
void SiebMeyerWriter::write(const Rout& rout) {
  note_work();
  const Eigen::Vector2d from_mm = at_mm_;
  const Eigen::Vector2d to_mm = rout.commanded.in_mm();
  if (has_routed_ && steps(to_mm) == steps(from_mm)) return;
  has_routed_ = true;
  open_line(to_mm);
  const Eigen::Vector2d center_mm = rout.commanded_center.in_mm();
  const Length step = digits().step();
  if (rout.kind == RoutKind::Line || is_flat(from_mm, to_mm, center_mm, step)) {
    line_ += "G1";
  } else {
    const bool is_clockwise = (rout.kind == RoutKind::Clockwise) != is_mirrored();
    line_ += is_clockwise ? "G2" : "G3";
    const Eigen::Vector2d start_mm = on_grid(from_mm, written_from_work(), step);
    const Eigen::Vector2d end_mm = on_grid(to_mm, written_from_work(), step);
    const Eigen::Vector2d center_to_start_mm =
        start_mm - center_of_rounded(start_mm, end_mm, center_mm);
    const std::size_t begin = line_.size();
    append_point(center_to_start_mm, "IJ");
    if (line_.size() > kLongArc && digits().n_decimals > kShortDecimals) {
      line_.resize(begin);
      append_point(center_to_start_mm, "IJ", kShortDecimals);
    }
  }
  say_feed(rout);
  if (side_ != told_side_) {
    const bool is_left = (side_ == CompensationSide::Left) != is_mirrored();
    line_ += side_ == CompensationSide::Off ? "G40" : is_left ? "G41" : "G42";
    told_side_ = side_;
  }
  line_ += std::exchange(rout_words_, {});
  if (const DepthOfCut* const told = told_cut(rout.cut)) say_depth(*told, true);
}

/// A router that was only lowered and raised routs a line without length, or it would stay up.
void SiebMeyerWriter::write(const Retract& retract) {
  if (retract.with_clamping && is_foreign()) lose_once("clamping while the router is raised (M16)");
  if (is_down_ && !has_routed_) {
    open_line(at_mm_);
    line_ += "G1";
  }
  is_down_ = false;
  has_routed_ = false;
  tool_up_line(at_mm_);
  ends_contour_ = true;
}

/// The control compensates for the diameter of the tool table.
void SiebMeyerWriter::write(const Compensation& compensation) {
  side_ = compensation.side;
  if (side_ == CompensationSide::Off || !is_foreign()) return;
  if (!compensation.value) {
    return lose_once(
        "a compensation index without a value in the header (the tool's diameter is used)");
  }
  const auto tool = tools_.find(tool_);
  const bool is_same = tool != tools_.end() && tool->second.diameter &&
                       std::abs((*tool->second.diameter - *compensation.value).in_um()) < kSame_um;
  if (!is_same) {
    refuse(fmt::format("a compensation for {:g} mm, which is not the tool's diameter",
                       compensation.value->in_mm()),
           "the tool's diameter");
  }
}

// --- stops and texts ---------------------------------------------------------------------------

/// A program ends where its text does.
void SiebMeyerWriter::write(const Stop& stop) {
  if (stop.from_absolute_zero) lose("the place to stop at");
  switch (stop.kind) {
    case StopKind::EndAccepted:
      return line('(' + std::string(kEndAcceptedComment) + ')');
    case StopKind::EndNoRewind:
    case StopKind::EndRewind:
    case StopKind::HeaderEnd:  // it waits for START anyway
      return;
    case StopKind::Inspection:
      return line("M47,INSPECTION STOP");
    case StopKind::Optional:
      // Alone it would send the table to machine zero.
      if (!stop.is_at_place) return line("M20");
      place_words().may_stop = true;
      return;
  }
}

void SiebMeyerWriter::write(const Message& what) {
  std::string_view text = what.text;
  while (true) {
    const auto end = text.find('\n');
    message(text.substr(0, end));
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

void SiebMeyerWriter::write(const Dwell& dwell) {
  lose(fmt::format("waiting for {:g} s", dwell.duration.in_s()));
}

/// A place on the machine, whatever the program's axes are (CNC command FA).
void SiebMeyerWriter::write(const ZeroSet& zero) {
  if (zero.is_reset) return line("M49,NOFA");
  const Eigen::Vector2d place_mm = (zero.work_zero - options().absolute_zero).in_mm();
  finish_line();
  line_ = "M49,FAX";
  append_number(place_mm.x());
  line_ += 'Y';
  append_number(place_mm.y());
  finish_line();
}

}  // namespace panelcal
