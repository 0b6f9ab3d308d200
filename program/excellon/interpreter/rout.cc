// SPDX-License-Identifier: Apache-2.0
// Routing: G00 to G03, M14 to M17, G40 to G42, and the routed cycles G32, G33 and G87.
#include <algorithm>
#include <utility>

#include "program/excellon/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

/// The value of the tool's compensation index, which is its own number unless T#(#) says another.
std::optional<Length> compensation_value(const Walk& walk) {
  if (!walk.tool) return std::nullopt;
  const auto& values = walk.header.compensation_values;
  const auto found = values.find(walk.compensation_index.value_or(walk.tool->number));
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

std::optional<Feed> table_feed(Walk& walk) {
  walk.takes_feed_from_before |= !walk.feed_in_pattern;
  return walk.modal.feed;
}

void rout_arc(Walk& walk, const Block& block, const Eigen::Vector2d& from_mm, double step_mm) {
  const bool is_clockwise = walk.modal.motion == Motion::Clockwise;
  const bool has_center = walk.modal.center_offset_mm[0].has_value();
  if (!has_center && !walk.modal.radius_mm) {
    return walk.reporter.report(
        Code::ArcInvalid, block.first(), "A#, or I#J#, in this block or before it");
  }
  // Both ends of the arc and its centre are rounded.
  const double slack_mm = 2 * step_mm;
  const ArcFit fit =
      has_center ? arc_from_center_offset(
                       from_mm,
                       walk.modal.at_mm,
                       {*walk.modal.center_offset_mm[0], *walk.modal.center_offset_mm[1]},
                       is_clockwise,
                       slack_mm)
                 : arc_from_radius(
                       from_mm, walk.modal.at_mm, *walk.modal.radius_mm, is_clockwise, slack_mm);
  if (fit.fault != ArcFault::None) {
    return walk.reporter.report(
        Code::ArcInvalid,
        block.first(),
        fit.fault == ArcFault::NoChord
            ? "an end away from the start; a full circle takes two arcs"
            : "a centre equally far from both ends, for an arc of at most 180 degrees");
  }
  if (fit.adjusted_mm != 0) {
    walk.reporter.report(
        Code::ArcAdjusted, block, fmt::format(" by {:.4f} mm", fit.adjusted_mm), "");
  }
  walk.emitter.rout(block.line, fit.arc, table_feed(walk));
}

}  // namespace

bool refuse_while_plunged(Walk& walk, const Block& block) {
  if (!walk.is_plunged) return false;
  walk.reporter.report(Code::ToolPlunged, block.first(), "M16 or M17 before it");
  return true;
}

std::optional<Length> tool_diameter(const Walk& walk) {
  return walk.tool ? walk.tool->diameter : std::nullopt;
}

void drill_mode(Walk& walk, const Block& block) {
  if (refuse_while_plunged(walk, block)) return;
  walk.modal.motion = Motion::Drill;
  walk.modal.side = CompensationSide::Off;
  // Not as written: Format One's G81 would be another command in Format Two.
  walk.emitter.put(block.line, Setting{"G05"});
}

void set_table_feed(Walk& walk, const Block& block, std::optional<Feed> feed) {
  walk.modal.feed = feed;
  walk.feed_in_pattern.emplace(Place{walk.reporter.file(), block.line, block.column}, block.text);
}

void start_motion(Walk& walk, const Block& block, Motion motion) {
  if (motion == Motion::Rapid) {
    if (refuse_while_plunged(walk, block)) return;
    if (walk.modal.side != CompensationSide::Off && !walk.modal.has_routed) {
      walk.reporter.report(Code::CompensationUnused, block.first(), "G41 or G42 behind G00X#Y#");
    }
    walk.modal.side = CompensationSide::Off;
    walk.modal.has_start = false;
    walk.late_index.reset();
  } else if (walk.modal.motion == Motion::Drill) {
    return walk.reporter.report(
        Code::CommandMisplaced, block.first(), "rout mode: G00X#Y# before it");
  }
  walk.modal.motion = motion;
  walk.modal.has_hole = false;
  walk.last_cycle.reset();
  if (block.n_words > 1) move_or_rout(walk, block, block.all().subspan(1));
}

/// Coordinates in rout mode: a move with the tool up after G00, else a line or an arc. A, I, J and
/// F may come without coordinates and stay in force.
void move_or_rout(Walk& walk, const Block& block, std::span<const Word> words) {
  MotionWords read;
  if (!read_words(walk, block, words, "XYAIJF", read)) return;
  if (walk.modal.motion == Motion::Drill && (read.xy_mm[0] || read.xy_mm[1] || read.feed)) {
    return walk.reporter.report(
        Code::CommandMisplaced, block.in(words.front()), "rout mode: G00X#Y# before it");
  }
  if (read.radius_mm && (read.ij_mm[0] || read.ij_mm[1])) {
    return walk.reporter.report(
        Code::ArgumentInvalid, block.in(words.front()), "A#, or I#J#, not both");
  }
  if (read.feed) set_table_feed(walk, block, read.feed);
  if (read.radius_mm || read.ij_mm[0] || read.ij_mm[1]) walk.modal.arc_step_mm = read.step_mm;
  if (read.radius_mm) {
    walk.modal.radius_mm = read.radius_mm;
    walk.modal.center_offset_mm = {};
  }
  if (read.ij_mm[0] || read.ij_mm[1]) {
    walk.modal.center_offset_mm = {read.ij_mm[0].value_or(0), read.ij_mm[1].value_or(0)};
    walk.modal.radius_mm.reset();
  }
  if (!read.xy_mm[0] && !read.xy_mm[1]) return;
  if (walk.modal.motion == Motion::Rapid && refuse_while_plunged(walk, block)) return;
  if (walk.modal.motion != Motion::Rapid && !walk.is_plunged) {
    return walk.reporter.report(Code::RoutNotPlunged, block.first(), "G00X#Y#, then M15 or M14");
  }
  const Eigen::Vector2d from_mm = walk.modal.at_mm;
  if (!move_to(walk, block, read.xy_mm, AxisUser::Work)) return;
  const double from_step_mm = std::exchange(walk.modal.at_step_mm, read.step_mm);
  walk.modal.has_start = true;
  if (!walk.vision.is_ready_to_drill(block.line) || !has_tool(walk, block.line)) return;
  switch (walk.modal.motion) {
    case Motion::Rapid:
      return walk.emitter.move(block.line, walk.modal.at_mm);
    case Motion::Line:
      return walk.emitter.rout(block.line, walk.modal.at_mm, table_feed(walk));
    default:
      return rout_arc(walk,
                      block,
                      from_mm,
                      std::max({from_step_mm, walk.modal.at_step_mm, walk.modal.arc_step_mm}));
  }
}

void plunge(Walk& walk, const Block& block, PlungeKind kind) {
  if (refuse_while_plunged(walk, block)) return;
  if (walk.modal.motion == Motion::Drill || !walk.modal.has_start) {
    return walk.reporter.report(Code::CommandMisplaced, block.first(), "G00X#Y# before it");
  }
  if (!has_tool(walk, block.line)) return;
  walk.is_plunged = true;
  walk.modal.has_routed = true;
  if (walk.late_index && walk.modal.side != CompensationSide::Off) {
    const auto& [place, text] = *walk.late_index;
    walk.reporter.report(Code::CompensationLate,
                         place.line,
                         place.column,
                         quoted(text) + " behind the G00 of its contour",
                         "T#(#), then G00X#Y#");
  }
  walk.emitter.plunge(block.line, kind, walk.modal.side, compensation_value(walk));
}

void retract(Walk& walk, const Block& block, bool with_clamping) {
  walk.is_plunged = false;
  walk.emitter.put(block.line, Retract{with_clamping});
}

void switch_compensation(Walk& walk, const Block& block, CompensationSide side) {
  if (refuse_while_plunged(walk, block)) return;
  walk.modal.side = side;
  walk.modal.has_routed = false;
}

/// G32X#Y#A#, G33X#Y#A#: as the listing of the manual's section says.
void routed_circle(Walk& walk, const Block& block, Command command) {
  if (refuse_while_plunged(walk, block)) return;
  MotionWords read;
  if (!read_words(walk, block, block.all().subspan(1), "XYA", read)) return;
  if (!read.xy_mm[0] && !read.xy_mm[1]) {
    return walk.reporter.report(Code::CoordinateMissing, block.first(), "X and Y of the centre");
  }
  if (read.radius_mm) {
    walk.modal.radius_mm = read.radius_mm;
    walk.modal.center_offset_mm = {};
  }
  if (!walk.modal.radius_mm) {
    return walk.reporter.report(Code::ArcInvalid, block.first(), "A#, in this block or before it");
  }
  if (!move_to(walk, block, read.xy_mm, AxisUser::Work)) return;
  walk.modal.motion = Motion::Rapid;
  walk.modal.side = CompensationSide::Off;
  walk.modal.has_hole = false;
  walk.modal.has_start = false;
  walk.last_cycle.reset();
  if (!walk.vision.is_ready_to_drill(block.line) || !has_tool(walk, block.line)) return;
  std::optional<Length> value = compensation_value(walk);
  if (!value) value = tool_diameter(walk);
  if (!value) {
    return walk.reporter.report(
        Code::DiameterMissing, block.first(), "CP,#,# in the header, or C# of the tool");
  }
  const auto circle =
      excellon::routed_circle(walk.modal.at_mm, *walk.modal.radius_mm, value->in_mm());
  if (!circle) return refuse_cycle(walk, block, block.words[0], circle.error());

  const bool is_clockwise = command == Command::CircleClockwise;
  walk.emitter.move(block.line, circle->plunge_mm);
  walk.emitter.plunge(block.line, PlungeKind::Plain, CompensationSide::Off, std::nullopt);
  Eigen::Vector2d at_mm = circle->plunge_mm;
  for (const Eigen::Vector2d& to_mm :
       {circle->far_mm, circle->near_mm, circle->far_mm, circle->retract_mm}) {
    const ArcFit fit =
        arc_from_radius(at_mm, to_mm, circle->radius_mm, is_clockwise, 2 * rounding_mm(walk));
    walk.emitter.rout(block.line, fit.arc, table_feed(walk));
    at_mm = to_mm;
  }
  walk.emitter.put(block.line, Retract{false});
}

/// X1Y1G87X2Y2Z-#U#: there and back in passes, the router down all the time.
void step_slot(Walk& walk,
               const Block& block,
               const Eigen::Vector2d& start_mm,
               const Eigen::Vector2d& end_mm,
               const MotionWords& words) {
  if (!words.depth_mm || !words.initial_depth_mm) {
    return walk.reporter.report(Code::CycleInvalid, block.first(), "Z-# and U# behind G87X#Y#");
  }
  const auto passes = step_slot_depths(*words.initial_depth_mm, *words.depth_mm);
  if (!passes) return refuse_cycle(walk, block, block.words[0], passes.error());
  if (walk.options.step_slots == Cycles::Kept) {
    return walk.emitter.step_slot(block.line,
                                  start_mm,
                                  end_mm,
                                  mm(*words.initial_depth_mm),
                                  mm(*words.depth_mm),
                                  table_feed(walk));
  }
  const std::optional<Feed> feed = table_feed(walk);
  const Length final_depth = walk.tool->depth_offset.value_or(Length());
  if (!walk.emitter.is_executing()) {
    walk.emitter.count_operations(2 * passes->size() + 2, block.line);
    return;
  }
  walk.emitter.move(block.line, start_mm);
  for (std::int64_t i = 0; i < passes->size() && !walk.has_ended(); ++i) {
    walk.emitter.plunge(block.line,
                        PlungeKind::Plain,
                        CompensationSide::Off,
                        std::nullopt,
                        final_depth + mm((*passes)[i]));
    walk.emitter.rout(block.line, i % 2 == 0 ? end_mm : start_mm, feed);
  }
  walk.emitter.put(block.line, Retract{false});
}

}  // namespace panelcal::excellon
