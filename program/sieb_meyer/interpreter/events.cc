// SPDX-License-Identifier: Apache-2.0
// Tools, and what the machine does by itself.
#include <algorithm>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {

/// A tool that is in the spindle already is not changed.
void Interpreter::take_tool(const Block& block, const Order& order) {
  const bool repeats = std::exchange(repeats_tool_, false);
  if (!order.tool) {
    repeats_tool_ = repeats;
    return;
  }
  if (tool_ && tool_->number == *order.tool && !repeats) return;
  if (is_plunged_ || piece_) {
    return report(
        Code::ContourUnclosed, block, quoted(block.text), "a T0 line before the tool change");
  }
  machine_at_mm_.reset();
  tool_ = layout_.taken_tool(*order.tool);
  emitter_.take(block.line, {*tool_, std::nullopt});
}

void Interpreter::function(int line, FunctionKind kind, std::string_view text, bool is_at_place) {
  emitter_.put(line,
               Function{.kind = kind,
                        .text = text,
                        .tool = 0,
                        .next_tool = std::nullopt,
                        .is_at_place = is_at_place});
}

void Interpreter::stop_at_place(int line) {
  emitter_.put(line, panelcal::Stop{.kind = StopKind::Optional, .is_at_place = true});
}

/// An event inside a contour waits for the piece that is routed in the same line, M20 and M21 of a
/// pattern for its holes. The manual has no machine functions in contours but M21.
void Interpreter::events_before(const Block& block, const Order& order) {
  const bool routs = (order.motion || modal_.motion || is_routing()) && !order.is_tool_up;
  const bool begins_pattern = order.v || order.nibble == Command::NibbleSlot;
  const auto refuse = [&](std::string expected) {
    report(Code::ContourUnclosed, block, quoted(block.text), std::move(expected));
    ended_ = true;
  };
  if (order.may_stop) {
    if (routs) return refuse("M20 in a T0 line or a drilling line");
    machine_at_mm_.reset();  // the machine goes to its zero, or to the line's place
    if (!order.has_xy()) {
      emitter_.put(block.line, panelcal::Stop{.kind = StopKind::Optional});
    } else if (!begins_pattern) {
      stop_at_place(block.line);
    }
  }
  if (order.stop && routs && !order.has_xy()) {
    return refuse("M28 and M29 in a rout line with X or Y, or behind the T0 line");
  }
  if (order.text && routs) return refuse("a T0 line before it");
  const auto event = [&](FunctionKind kind, std::string_view text) {
    if (routs) {
      waiting_events_.emplace_back(kind, text);
    } else {
      function(block.line, kind, text);
    }
  };
  if (order.checks_breakage) {
    const bool is_on = *order.checks_breakage;
    event(is_on ? FunctionKind::BreakageCheckOn : FunctionKind::BreakageCheckOff,
          is_on ? "M95" : "M94");
  }
  for (const Command command : order.functions) {
    if (command == Command::OutputOn) {
      if (routs) {
        waiting_events_.emplace_back(FunctionKind::MachineFunction, "M21");
      } else if (!begins_pattern) {
        if (order.is_tool_up) machine_at_mm_.reset();  // its coordinate is executed, also in place
        function(block.line, FunctionKind::MachineFunction, "M21", order.has_xy());
      }
      continue;
    }
    if (routs) return refuse("machine functions outside contours");
    machine_at_mm_.reset();
    function(block.line, FunctionKind::MachineFunction, code_text(command));
  }
  texts(block, order);
}

/// Texts that do not drill are done before the coordinate of their line, like a stop.
void Interpreter::texts(const Block& block, const Order& order) {
  if (!order.text) return;
  switch (*order.text) {
    case Command::UserMessage:
      return message(block);
    case Command::CncCommand:
      if (block.n_words != 1) {
        return report(Code::BlockNotAlone, block, quoted(block.text), "M49 in a line of its own");
      }
      return cnc_command(block);
    case Command::DeviceText:
      machine_at_mm_.reset();
      return function(block.line, FunctionKind::TextForDevice, block.argument);
    case Command::CameraByte:
    case Command::CameraText:
    case Command::CorrectionValues:
      return camera_text(block, *order.text);
    default:
      return;  // M97, M98 and M99 come in the coordinate's place
  }
}

/// The signs that the control takes from the text's beginning are the control's.
void Interpreter::message(const Block& block) {
  machine_at_mm_.reset();  // &P goes to the park position
  emitter_.put(block.line, Message{block.argument});
}

void Interpreter::events_after(const Block& block, const Order& order) {
  if (!order.stop) return;
  if (is_routing()) {
    // The table leaves the contour, so the cutter comes up. How a control goes on without T0, the
    // manual does not say: the motion remains, for such a line to be refused and not to drill.
    const std::optional<Command> motion = modal_.motion;
    end_contour(block.line);
    modal_.motion = motion;
  }
  machine_at_mm_.reset();
  contour_ = Contour::None;
  const bool goes_home = *order.stop == Command::MachineZero;
  function(block.line,
           goes_home ? FunctionKind::MachineZero : FunctionKind::ParkPosition,
           goes_home ? "M28" : "M29");
}

/// M56 to M58: check areas are the control's, forbidden ones leave holes out.
void Interpreter::area(const Block& block, const Order& order) {
  if (!move_to(order)) {
    return report(Code::CoordinateMissing, block, quoted(block.text), "X#Y# of the area");
  }
  modal_.reference = Reference::Area;
  const bool is_ignored = !steps_.empty() && !areas_in_copies_.value_or(true);
  if (!obeys_areas_ && !is_ignored && !std::exchange(warned_areas_, true)) {
    reporter_.report(Code::AreasAssumed,
                     block.line,
                     block.column,
                     quoted(block.text),
                     "M49,PRGM,C or M49,PRGM,-C, or [program] obeys_areas in machine.toml");
  }
  contour_ = Contour::None;
  if (!obeys_areas_.value_or(true)) return;
  if (*order.area != Command::ForbiddenArea) return check_area(block, order);
  if (is_ignored) return;
  constexpr std::size_t kMostAreas = 99;
  if (!order.rounding_mm || *order.rounding_mm <= 0) {
    return report(Code::ArgumentInvalid, block, quoted(block.text), "M58D# with the edge's length");
  }
  note_scaling(block.line);
  const auto center = place_.placement(position_mm<frame::Programmed>(modal_.at_mm));
  const double half_mm = *order.rounding_mm / 2;
  const bool is_known = std::ranges::any_of(areas_, [&](const ForbiddenArea& known) {
    return known.center == center && known.half_mm == half_mm;
  });
  if (is_known) return;
  if (areas_.size() == kMostAreas) {
    return report(Code::ArgumentInvalid, block, quoted(block.text), "at most 99 forbidden areas");
  }
  areas_.push_back({center, half_mm});
  // Without a text: the holes are left out already, and the control must not omit others.
  function(block.line, FunctionKind::ForbiddenArea, {});
}

/// M56 and M57 go to the machine as absolute places, so nothing may have moved them: whether an
/// area in a section moves with its copies, the manual does not say.
void Interpreter::check_area(const Block& block, const Order& order) {
  const CorrectionStack& stack = measuring_.corrections().stack;
  const bool is_placed =
      placement_.linear() != frame_.linear() || placement_.translation() != frame_.translation();
  const bool is_scaled = rotation_rad_ != 0 || (scaling_.is_set() && scaling_.is_on.value_or(true));
  const bool is_corrected = stack.base() != nullptr || stack.nested() != nullptr;
  if (is_placed || is_scaled || is_corrected) {
    const std::string by = is_placed   ? "the offset of a section or call"
                           : is_scaled ? "a scale or rotation"
                                       : "a correction";
    const std::string code = code_text(*order.area);
    return report(Code::NotSupported,
                  block,
                  fmt::format("{} under {}: the manual does not say whether it moves a check area",
                              quoted(block.text),
                              by),
                  fmt::format("X#Y#{} ahead of it, where the area is to lie on the table", code));
  }
  function(
      block.line,
      FunctionKind::CheckArea,
      fmt::format("X{:.3f}Y{:.3f}{}", modal_.at_mm.x(), modal_.at_mm.y(), code_text(*order.area)));
}

}  // namespace panelcal::sieb_meyer
