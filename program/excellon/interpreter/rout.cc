// SPDX-License-Identifier: Apache-2.0
// Routing: G00 to G03, M14 to M17, G40 to G42, and the routed cycles G32, G33 and G87.
#include <algorithm>
#include <cmath>
#include <utility>

#include "program/excellon/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::excellon {
bool Interpreter::refuse_while_plunged(const Block& block) {
  if (!is_plunged_) return false;
  report(Code::ToolPlunged, block, block.words[0], "M16 or M17 before it");
  return true;
}

std::optional<Length> Interpreter::tool_diameter() const {
  return tool_ ? tool_->diameter : std::nullopt;
}

/// The value of the tool's compensation index, which is its own number unless T#(#) says another.
std::optional<Length> Interpreter::compensation_value() const {
  if (!tool_) return std::nullopt;
  const auto& values = header_.compensation_values;
  const auto found = values.find(compensation_index_.value_or(tool_->number));
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

bool Interpreter::drill_mode(const Block& block) {
  if (refuse_while_plunged(block)) return false;
  modal_.motion = Motion::Drill;
  modal_.side = CompensationSide::Off;
  return true;
}

void Interpreter::set_table_feed(const Block& block, std::optional<Feed> feed) {
  modal_.feed = feed;
  feed_in_pattern_.emplace(Place{reporter_.file(), block.line, block.column}, block.text);
}

std::optional<Feed> Interpreter::table_feed() {
  takes_feed_from_before_ |= !feed_in_pattern_;
  return modal_.feed;
}

void Interpreter::start_motion(const Block& block, Motion motion) {
  if (motion == Motion::Rapid) {
    if (refuse_while_plunged(block)) return;
    if (modal_.side != CompensationSide::Off && !modal_.has_routed) {
      report(Code::CompensationUnused, block, block.words[0], "G41 or G42 behind G00X#Y#");
    }
    modal_.side = CompensationSide::Off;
    modal_.has_start = false;
    late_index_.reset();
  } else if (modal_.motion == Motion::Drill) {
    return report(Code::CommandMisplaced, block, block.words[0], "rout mode: G00X#Y# before it");
  }
  modal_.motion = motion;
  modal_.has_hole = false;
  last_cycle_.reset();
  if (block.n_words > 1) move_or_rout(block, block.all().subspan(1));
}

/// Coordinates in rout mode: a move with the tool up after G00, else a line or an arc. A, I, J and
/// F may come without coordinates and stay in force.
void Interpreter::move_or_rout(const Block& block, std::span<const Word> words) {
  MotionWords read;
  if (!read_words(block, words, "XYAIJF", read)) return;
  if (modal_.motion == Motion::Drill && (read.xy_mm[0] || read.xy_mm[1] || read.feed)) {
    return report(Code::CommandMisplaced, block, words.front(), "rout mode: G00X#Y# before it");
  }
  if (read.radius_mm && (read.ij_mm[0] || read.ij_mm[1])) {
    return report(Code::ArgumentInvalid, block, words.front(), "A#, or I#J#, not both");
  }
  if (read.feed) set_table_feed(block, read.feed);
  if (read.radius_mm || read.ij_mm[0] || read.ij_mm[1]) modal_.arc_step_mm = read.step_mm;
  if (read.radius_mm) {
    modal_.radius_mm = read.radius_mm;
    modal_.center_offset_mm = {};
  }
  if (read.ij_mm[0] || read.ij_mm[1]) {
    modal_.center_offset_mm = {read.ij_mm[0].value_or(0), read.ij_mm[1].value_or(0)};
    modal_.radius_mm.reset();
  }
  if (!read.xy_mm[0] && !read.xy_mm[1]) return;
  if (modal_.motion == Motion::Rapid && refuse_while_plunged(block)) return;
  if (modal_.motion != Motion::Rapid && !is_plunged_) {
    return report(Code::RoutNotPlunged, block, block.words[0], "G00X#Y#, then M15 or M14");
  }
  const Eigen::Vector2d from_mm = modal_.at_mm;
  if (!move_to(block, read.xy_mm, AxisUser::Work)) return;
  const double from_step_mm = std::exchange(modal_.at_step_mm, read.step_mm);
  modal_.has_start = true;
  if (!vision_.is_ready_to_drill(block.line) || !has_tool(block.line)) return;
  switch (modal_.motion) {
    case Motion::Rapid:
      return emitter_.move(block.line, modal_.at_mm);
    case Motion::Line:
      return emitter_.rout(block.line, modal_.at_mm, table_feed());
    default:
      return rout_arc(
          block, from_mm, std::max({from_step_mm, modal_.at_step_mm, modal_.arc_step_mm}));
  }
}

void Interpreter::rout_arc(const Block& block, const Eigen::Vector2d& from_mm, double step_mm) {
  const bool is_clockwise = modal_.motion == Motion::Clockwise;
  const bool has_center = modal_.center_offset_mm[0].has_value();
  if (!has_center && !modal_.radius_mm) {
    return report(
        Code::ArcInvalid, block, block.words[0], "A#, or I#J#, in this block or before it");
  }
  // Both ends of the arc and its centre are rounded.
  const double slack_mm = 2 * step_mm;
  const ArcFit fit =
      has_center
          ? arc_from_center_offset(from_mm,
                                   modal_.at_mm,
                                   {*modal_.center_offset_mm[0], *modal_.center_offset_mm[1]},
                                   is_clockwise,
                                   slack_mm)
          : arc_from_radius(from_mm, modal_.at_mm, *modal_.radius_mm, is_clockwise, slack_mm);
  if (fit.fault != ArcFault::None) {
    return report(Code::ArcInvalid,
                  block,
                  block.words[0],
                  fit.fault == ArcFault::NoChord
                      ? "an end away from the start; a full circle takes two arcs"
                      : "a centre equally far from both ends, for an arc of at most 180 degrees");
  }
  if (fit.adjusted_mm != 0) {
    reporter_.report(Code::ArcAdjusted,
                     block.line,
                     block.column,
                     fmt::format("{} by {:.4f} mm", quoted(block.text), fit.adjusted_mm));
  }
  emitter_.rout(block.line, fit.arc, table_feed());
}

void Interpreter::plunge(const Block& block, PlungeKind kind) {
  if (refuse_while_plunged(block)) return;
  if (modal_.motion == Motion::Drill || !modal_.has_start) {
    return report(Code::CommandMisplaced, block, block.words[0], "G00X#Y# before it");
  }
  if (!has_tool(block.line)) return;
  is_plunged_ = true;
  modal_.has_routed = true;
  if (late_index_ && modal_.side != CompensationSide::Off) {
    const auto& [place, text] = *late_index_;
    reporter_.report(Code::CompensationLate,
                     place.line,
                     place.column,
                     quoted(text) + " behind the G00 of its contour",
                     "T#(#), then G00X#Y#");
  }
  emitter_.plunge(block.line, kind, modal_.side, compensation_value());
}

void Interpreter::retract(const Block& block, bool with_clamping) {
  is_plunged_ = false;
  emitter_.put(block.line, Retract{with_clamping});
}

void Interpreter::switch_compensation(const Block& block, CompensationSide side) {
  if (refuse_while_plunged(block)) return;
  modal_.side = side;
  modal_.has_routed = false;
}

/// G32X#Y#A#, G33X#Y#A#: as the listing of the manual's section says.
void Interpreter::routed_circle(const Block& block, Command command) {
  if (refuse_while_plunged(block)) return;
  MotionWords read;
  if (!read_words(block, block.all().subspan(1), "XYA", read)) return;
  if (!read.xy_mm[0] && !read.xy_mm[1]) {
    return report(Code::CoordinateMissing, block, block.words[0], "X and Y of the centre");
  }
  if (read.radius_mm) {
    modal_.radius_mm = read.radius_mm;
    modal_.center_offset_mm = {};
  }
  if (!modal_.radius_mm) {
    return report(Code::ArcInvalid, block, block.words[0], "A#, in this block or before it");
  }
  if (!move_to(block, read.xy_mm, AxisUser::Work)) return;
  modal_.motion = Motion::Rapid;
  modal_.side = CompensationSide::Off;
  modal_.has_hole = false;
  modal_.has_start = false;
  last_cycle_.reset();
  if (!vision_.is_ready_to_drill(block.line) || !has_tool(block.line)) return;
  std::optional<Length> value = compensation_value();
  if (!value) value = tool_diameter();
  if (!value) {
    return report(
        Code::DiameterMissing, block, block.words[0], "CP,#,# in the header, or C# of the tool");
  }
  const auto circle = excellon::routed_circle(modal_.at_mm, *modal_.radius_mm, value->in_mm());
  if (!circle) return refuse_cycle(block, block.words[0], circle.error());

  const bool is_clockwise = command == Command::CircleClockwise;
  emitter_.move(block.line, circle->plunge_mm);
  emitter_.plunge(block.line, PlungeKind::Plain, CompensationSide::Off, std::nullopt);
  Eigen::Vector2d at_mm = circle->plunge_mm;
  for (const Eigen::Vector2d& to_mm :
       {circle->far_mm, circle->near_mm, circle->far_mm, circle->retract_mm}) {
    const ArcFit fit =
        arc_from_radius(at_mm, to_mm, circle->radius_mm, is_clockwise, 2 * rounding_mm());
    emitter_.rout(block.line, fit.arc, table_feed());
    at_mm = to_mm;
  }
  emitter_.put(block.line, Retract{false});
}

/// X1Y1G87X2Y2Z-#U#: there and back in passes, the router down all the time.
void Interpreter::step_slot(const Block& block,
                            const Eigen::Vector2d& start_mm,
                            const Eigen::Vector2d& end_mm,
                            const MotionWords& words) {
  if (!words.depth_mm || !words.initial_depth_mm) {
    return report(Code::CycleInvalid, block, block.words[0], "Z-# and U# behind G87X#Y#");
  }
  const auto passes = step_slot_depths(*words.initial_depth_mm, *words.depth_mm);
  if (!passes) return refuse_cycle(block, block.words[0], passes.error());
  if (options_.step_slots == Cycles::Kept) {
    return emitter_.step_slot(block.line,
                              start_mm,
                              end_mm,
                              mm(*words.initial_depth_mm),
                              mm(*words.depth_mm),
                              table_feed());
  }
  const std::optional<Feed> feed = table_feed();
  const Length final_depth = tool_->depth_offset.value_or(Length());
  if (!emitter_.is_executing()) {
    emitter_.count_operations(2 * passes->size() + 2, block.line);
    return;
  }
  emitter_.move(block.line, start_mm);
  for (std::int64_t i = 0; i < passes->size() && !has_ended(); ++i) {
    emitter_.plunge(block.line,
                    PlungeKind::Plain,
                    CompensationSide::Off,
                    std::nullopt,
                    final_depth + mm((*passes)[i]));
    emitter_.rout(block.line, i % 2 == 0 ? end_mm : start_mm, feed);
  }
  emitter_.put(block.line, Retract{false});
}

}  // namespace panelcal::excellon
