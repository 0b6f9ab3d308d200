// SPDX-License-Identifier: Apache-2.0
// Holes: single ones, patterns, nibbling and texts.
#include <algorithm>
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include "program/sieb_meyer/text/plain_text.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// Each hole is one operation, also one that is left out.
void drill_all(Walk& walk, int line, const HoleSequence& holes) {
  if (!walk.emitter.has_room_for(holes.size(), line)) return;
  if (holes.size() > 0 && !walk.emitter.needs_places() && walk.areas.empty() && !uses_grid(walk)) {
    drill(walk, line, holes[0]);
    walk.emitter.count_operations(holes.size() - 1, line);
    return;
  }
  for (std::int64_t i = 0; i < holes.size() && !walk.has_ended(); ++i) drill(walk, line, holes[i]);
}

}  // namespace

bool has_tool(Walk& walk, int line) {
  if (walk.tool) return true;
  if (!std::exchange(walk.reported_no_tool, true)) {
    walk.reporter.report(Code::ToolMissing, line, "", "T#");
  }
  return false;
}

/// Every stroke and every move for one: false and an error without a tool, or where it is not
/// certain how deep to go. Warns where it is taken to be certain where to go.
bool may_work(Walk& walk, int line) {
  if (!has_tool(walk, line) || !is_decided(walk, line)) return false;
  if (walk.optical.is_assumed_on()) {
    walk.optical.note_stroke(line);
    update_care(walk);
  }
  return true;
}

void drill(Walk& walk, int line, const Eigen::Vector2d& at_mm) {
  if (!may_work(walk, line)) {
    walk.emitter.count_operations(1, line);
    return;
  }
  walk.contour = Contour::None;
  walk.machine_at_mm.reset();
  if (!walk.areas.empty() && is_forbidden(walk, line, at_mm)) return;
  judge_control(walk, line);
  if (uses_grid(walk)) walk.emitter.set_cut(cut_at(walk, line, at_mm));
  walk.emitter.drill(line, at_mm);
}

/// The control says nothing about a hole that it leaves out; we do.
bool is_forbidden(Walk& walk, int line, const Eigen::Vector2d& at_mm) {
  const auto nominal = walk.place.placement(position_mm<frame::Programmed>(at_mm));
  const bool is_inside = std::ranges::any_of(walk.areas, [&](const ForbiddenArea& area) {
    const Eigen::Vector2d apart_mm = (nominal - area.center).in_mm().cwiseAbs();
    return apart_mm.maxCoeff() <= area.half_mm;
  });
  if (!is_inside) return false;
  walk.reporter.report(
      Code::HoleOmitted,
      line,
      fmt::format("nominal ({:.4f}, {:.4f}) mm", nominal.in_mm().x(), nominal.in_mm().y()));
  walk.emitter.put(line,
                   Function{.kind = FunctionKind::HoleOmitted,
                            .text = {},
                            .tool = walk.tool->number,
                            .next_tool = {}});
  return true;
}

// --- patterns ----------------------------------------------------------------------------------

void begin_pattern(Walk& walk, const Block& block, const Order& order) {
  if (!holds_only(walk, block, order, kPattern | kNibble | kXy)) return;
  if (refuse_in_contour(walk, block)) return;
  if (order.v && order.nibble) {
    return walk.reporter.report(Code::CommandMisplaced, block, "V1 to V4, or G85");
  }
  if (!move_to(walk, order)) {
    return walk.reporter.report(Code::CoordinateMissing, block, "X#Y# of the first point");
  }
  const bool has_output =
      std::ranges::find(order.functions, Command::OutputOn) != order.functions.end();
  walk.pattern = PendingPattern{order.v.value_or(0),
                                walk.modal.at_mm,
                                block.line,
                                std::string(block.text),
                                order.may_stop,
                                has_output};
}

void end_pattern(Walk& walk, const Block& block, const Order& order) {
  const PendingPattern pattern = *std::exchange(walk.pattern, std::nullopt);
  const auto refuse = [&](const std::string& what, std::string expected) {
    walk.reporter.report(Code::CycleInvalid, block, ": " + what, std::move(expected));
  };
  if (!order.has_xy() || order.peck || order.pulse || (parts_of(order) & ~(kXy | kCount)) != 0) {
    return refuse(quoted(pattern.text) + " waits for its second point",
                  "X#Y#, and W#, alone in the next line");
  }
  move_to(walk, order);
  if (pattern.may_stop) stop_at_place(walk, block.line);
  if (pattern.has_output) {
    function(walk, block.line, FunctionKind::MachineFunction, "M21", true);
  }
  const Eigen::Vector2d second_mm = walk.modal.at_mm;
  const auto count = order.count ? std::optional<std::int64_t>(*order.count) : std::nullopt;
  if ((pattern.v == 2 || pattern.v == 4) && !count) {
    return refuse("the number of holes is missing", "W# in this line");
  }
  tl::expected<HoleSequence, std::string> holes = tl::unexpected<std::string>("");
  switch (pattern.v) {
    case 1:
      holes = dual_row(pattern.first_mm, second_mm, count);
      break;
    case 2:
      holes = single_row(pattern.first_mm, second_mm, *count);
      break;
    case 3:
      holes = quadruple_row(pattern.first_mm, second_mm, count);
      break;
    case 4:
      holes = circular_row(pattern.first_mm, second_mm, *count);
      break;
    default: {
      const auto diameter_mm = tool_diameter_mm(walk, block);
      if (!diameter_mm) return;
      if (walk.options.slots == Cycles::Kept && walk.areas.empty() && !walk.surface.has_grid() &&
          !walk.emitter.follows_map()) {
        const auto whole = nibbled_slot(pattern.first_mm, second_mm, *diameter_mm, walk.nibbling);
        if (!whole) return refuse(whole.error(), "");
        if (!may_work(walk, block.line)) return;
        judge_control(walk, block.line);
        return walk.emitter.slot(block.line, pattern.first_mm, second_mm, whole->size());
      }
      holes = nibbled_slot(pattern.first_mm, second_mm, *diameter_mm, walk.nibbling);
    }
  }
  if (!holes) return refuse(holes.error(), "");
  drill_all(walk, block.line, *holes);
}

void nibble_circle(Walk& walk, const Block& block, const Order& order) {
  if (refuse_in_contour(walk, block)) return;
  if (!order.r_mm || order.ij_mm[0] || order.ij_mm[1]) {
    return walk.reporter.report(Code::CycleInvalid, block, "G84R# with the circle's radius");
  }
  if (!move_to(walk, order)) {
    return walk.reporter.report(Code::CoordinateMissing, block, "X#Y# of the centre");
  }
  const auto diameter_mm = tool_diameter_mm(walk, block);
  if (!diameter_mm) return;
  const auto holes = nibbled_circle(walk.modal.at_mm, *order.r_mm, *diameter_mm, walk.nibbling);
  if (!holes) return walk.reporter.report(Code::CycleInvalid, block, ": " + holes.error(), "");
  drill_all(walk, block.line, *holes);
}

std::optional<double> tool_diameter_mm(Walk& walk, const Block& block) {
  if (!has_tool(walk, block.line)) return std::nullopt;
  if (walk.tool->diameter) return walk.tool->diameter->in_mm();
  walk.reporter.report(Code::DiameterMissing,
                       block,
                       fmt::format(" needs the diameter of T{}", walk.tool->number),
                       "D# in the tool table behind $");
  return std::nullopt;
}

// --- texts -------------------------------------------------------------------------------------

/// M97, M98: the first character's lower left hole is at the coordinate; M98 writes upwards.
void drill_text(Walk& walk, const Block& block, bool upwards) {
  const auto cells =
      expand_text(block.argument, walk.settings.text, step_number(walk), walk.settings.characters);
  if (!cells) {
    return walk.reporter.report(Code::ArgumentInvalid,
                                block.line,
                                block.argument_column + static_cast<int>(cells.error().index),
                                cells.error().what,
                                cells.error().expected);
  }
  const auto diameter_mm = tool_diameter_mm(walk, block);
  if (!diameter_mm) return;
  const TextLayout layout(*cells, walk.settings.characters);
  const double pitch_mm = kPitchDiameters * *diameter_mm;
  const Eigen::Vector2d start_mm = walk.modal.at_mm;
  for (std::int64_t i = 0; i < layout.size() && !walk.has_ended(); ++i) {
    const Eigen::Vector2d dot_mm = layout[i] * pitch_mm;
    const Eigen::Vector2d turned_mm = upwards ? Eigen::Vector2d(-dot_mm.y(), dot_mm.x()) : dot_mm;
    drill(walk, block.line, start_mm + turned_mm);
  }
}

}  // namespace panelcal::sieb_meyer
