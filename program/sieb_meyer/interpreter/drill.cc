// SPDX-License-Identifier: Apache-2.0
// Holes: single ones, patterns, nibbling and texts.
#include <algorithm>
#include <cmath>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include "program/sieb_meyer/text/plain_text.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {

bool Interpreter::has_tool(int line) {
  if (tool_) return true;
  if (!std::exchange(reported_no_tool_, true)) {
    reporter_.report(Code::ToolMissing, line, 1, "", "T#");
  }
  return false;
}

/// Every stroke and every move for one: false and an error without a tool, or where it is not
/// certain how deep to go. Warns where it is taken to be certain where to go.
bool Interpreter::may_work(int line) {
  if (!has_tool(line) || !is_decided(line)) return false;
  if (optical_.is_assumed_on()) {
    optical_.note_stroke(line);
    update_care();
  }
  return true;
}

void Interpreter::drill(int line, const Eigen::Vector2d& at_mm) {
  if (!may_work(line)) {
    emitter_.count_operations(1, line);
    return;
  }
  contour_ = Contour::None;
  machine_at_mm_.reset();
  if (!areas_.empty() && is_forbidden(line, at_mm)) return;
  judge_control(line);
  if (uses_grid()) emitter_.set_cut(cut_at(line, at_mm));
  emitter_.drill(line, at_mm);
}

/// The control says nothing about a hole that it leaves out; we do.
bool Interpreter::is_forbidden(int line, const Eigen::Vector2d& at_mm) {
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  const bool is_inside = std::ranges::any_of(areas_, [&](const ForbiddenArea& area) {
    const Eigen::Vector2d apart_mm = (nominal - area.center).in_mm().cwiseAbs();
    return apart_mm.maxCoeff() <= area.half_mm;
  });
  if (!is_inside) return false;
  reporter_.report(
      Code::HoleOmitted,
      line,
      1,
      fmt::format("nominal ({:.4f}, {:.4f}) mm", nominal.in_mm().x(), nominal.in_mm().y()),
      "");
  emitter_.put(
      line,
      Function{
          .kind = FunctionKind::HoleOmitted, .text = {}, .tool = tool_->number, .next_tool = {}});
  return true;
}

/// Each hole is one operation, also one that is left out.
void Interpreter::drill_all(int line, const HoleSequence& holes) {
  if (!emitter_.has_room_for(holes.size(), line)) return;
  if (holes.size() > 0 && !emitter_.needs_places() && areas_.empty() && !uses_grid()) {
    drill(line, holes[0]);
    emitter_.count_operations(holes.size() - 1, line);
    return;
  }
  for (std::int64_t i = 0; i < holes.size() && !has_ended(); ++i) drill(line, holes[i]);
}

// --- patterns ----------------------------------------------------------------------------------

void Interpreter::begin_pattern(const Block& block, const Order& order) {
  if (!holds_only(block, order, kPattern | kNibble | kXy)) return;
  if (modal_.motion || is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (order.v && order.nibble) {
    return report(Code::CommandMisplaced, block, quoted(block.text), "V1 to V4, or G85");
  }
  if (!move_to(order)) {
    return report(Code::CoordinateMissing, block, quoted(block.text), "X#Y# of the first point");
  }
  const bool has_output =
      std::ranges::find(order.functions, Command::OutputOn) != order.functions.end();
  pattern_ = PendingPattern{order.v.value_or(0),
                            modal_.at_mm,
                            block.line,
                            std::string(block.text),
                            order.may_stop,
                            has_output};
}

void Interpreter::end_pattern(const Block& block, const Order& order) {
  const PendingPattern pattern = *std::exchange(pattern_, std::nullopt);
  const auto refuse = [&](const std::string& what, std::string expected) {
    report(Code::CycleInvalid, block, quoted(block.text) + ": " + what, std::move(expected));
  };
  if (!order.has_xy() || order.peck || order.pulse || (parts_of(order) & ~(kXy | kCount)) != 0) {
    return refuse(panelcal::quoted(pattern.text) + " waits for its second point",
                  "X#Y#, and W#, alone in the next line");
  }
  move_to(order);
  if (pattern.may_stop) stop_at_place(block.line);
  if (pattern.has_output) {
    function(block.line, FunctionKind::MachineFunction, "M21", true);
  }
  const Eigen::Vector2d second_mm = modal_.at_mm;
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
      const auto diameter_mm = tool_diameter_mm(block);
      if (!diameter_mm) return;
      if (options_.slots == Cycles::Kept && areas_.empty() && !surface_.has_grid() &&
          !emitter_.follows_map()) {
        const auto whole = nibbled_slot(pattern.first_mm, second_mm, *diameter_mm, nibbling_);
        if (!whole) return refuse(whole.error(), "");
        if (!may_work(block.line)) return;
        judge_control(block.line);
        return emitter_.slot(block.line, pattern.first_mm, second_mm, whole->size());
      }
      holes = nibbled_slot(pattern.first_mm, second_mm, *diameter_mm, nibbling_);
    }
  }
  if (!holes) return refuse(holes.error(), "");
  drill_all(block.line, *holes);
}

void Interpreter::nibble_circle(const Block& block, const Order& order) {
  if (modal_.motion || is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (!order.r_mm || order.ij_mm[0] || order.ij_mm[1]) {
    return report(Code::CycleInvalid, block, quoted(block.text), "G84R# with the circle's radius");
  }
  if (!move_to(order)) {
    return report(Code::CoordinateMissing, block, quoted(block.text), "X#Y# of the centre");
  }
  const auto diameter_mm = tool_diameter_mm(block);
  if (!diameter_mm) return;
  const auto holes = nibbled_circle(modal_.at_mm, *order.r_mm, *diameter_mm, nibbling_);
  if (!holes)
    return report(Code::CycleInvalid, block, quoted(block.text) + ": " + holes.error(), "");
  drill_all(block.line, *holes);
}

std::optional<double> Interpreter::tool_diameter_mm(const Block& block) {
  if (!has_tool(block.line)) return std::nullopt;
  if (tool_->diameter) return tool_->diameter->in_mm();
  report(Code::DiameterMissing,
         block,
         fmt::format("{} needs the diameter of T{}", quoted(block.text), tool_->number),
         "D# in the tool table behind $");
  return std::nullopt;
}

// --- texts -------------------------------------------------------------------------------------

/// M97, M98: the first character's lower left hole is at the coordinate; M98 writes upwards.
void Interpreter::drill_text(const Block& block, bool upwards) {
  const auto cells =
      expand_text(block.argument, settings_.text, step_number(), settings_.characters);
  if (!cells) {
    return reporter_.report(Code::ArgumentInvalid,
                            block.line,
                            block.argument_column + static_cast<int>(cells.error().index),
                            cells.error().what,
                            cells.error().expected);
  }
  const auto diameter_mm = tool_diameter_mm(block);
  if (!diameter_mm) return;
  const TextLayout layout(*cells, settings_.characters);
  const double pitch_mm = kPitchDiameters * *diameter_mm;
  const Eigen::Vector2d start_mm = modal_.at_mm;
  for (std::int64_t i = 0; i < layout.size() && !has_ended(); ++i) {
    const Eigen::Vector2d dot_mm = layout[i] * pitch_mm;
    const Eigen::Vector2d turned_mm = upwards ? Eigen::Vector2d(-dot_mm.y(), dot_mm.x()) : dot_mm;
    drill(block.line, start_mm + turned_mm);
  }
}

}  // namespace panelcal::sieb_meyer
