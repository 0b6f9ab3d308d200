// SPDX-License-Identifier: Apache-2.0
// Tools, and what the machine does by itself.
#include <algorithm>
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// The signs that the control takes from the text's beginning are the control's.
void message(Walk& walk, const Block& block) {
  walk.machine_at_mm.reset();  // &P goes to the park position
  walk.emitter.put(block.line, Message{block.argument});
}

/// Texts that do not drill are done before the coordinate of their line, like a stop.
void texts(Walk& walk, const Block& block, const Order& order) {
  if (!order.text) return;
  switch (*order.text) {
    case Command::UserMessage:
      return message(walk, block);
    case Command::CncCommand:
      if (block.n_words != 1) {
        return walk.reporter.report(Code::BlockNotAlone, block, "M49 in a line of its own");
      }
      return cnc_command(walk, block);
    case Command::DeviceText:
      walk.machine_at_mm.reset();
      return function(walk, block.line, FunctionKind::TextForDevice, block.argument);
    case Command::CameraByte:
    case Command::CameraText:
    case Command::CorrectionValues:
      return camera_text(walk, block, *order.text);
    default:
      return;  // M97, M98 and M99 come in the coordinate's place
  }
}

/// M56 and M57 go to the machine as absolute places, so nothing may have moved them: whether an
/// area in a section moves with its copies, the manual does not say.
void check_area(Walk& walk, const Block& block, const Order& order) {
  const CorrectionStack& stack = walk.measuring.corrections().stack;
  const bool is_placed = walk.placement.linear() != walk.frame.linear() ||
                         walk.placement.translation() != walk.frame.translation();
  const bool is_scaled =
      walk.rotation_rad != 0 || (walk.scaling.is_set() && walk.scaling.is_on.value_or(true));
  const bool is_corrected = stack.base() != nullptr || stack.nested() != nullptr;
  if (is_placed || is_scaled || is_corrected) {
    const std::string by = is_placed   ? "the offset of a section or call"
                           : is_scaled ? "a scale or rotation"
                                       : "a correction";
    const std::string code = code_text(*order.area);
    return walk.reporter.report(
        Code::NotSupported,
        block,
        fmt::format(" under {}: the manual does not say whether it moves a check area", by),
        fmt::format("X#Y#{} ahead of it, where the area is to lie on the table", code));
  }
  function(
      walk,
      block.line,
      FunctionKind::CheckArea,
      fmt::format(
          "X{:.3f}Y{:.3f}{}", walk.modal.at_mm.x(), walk.modal.at_mm.y(), code_text(*order.area)));
}

}  // namespace

/// A tool that is in the spindle already is not changed.
void take_tool(Walk& walk, const Block& block, const Order& order) {
  const bool repeats = std::exchange(walk.repeats_tool, false);
  if (!order.tool) {
    walk.repeats_tool = repeats;
    return;
  }
  if (walk.tool && walk.tool->number == *order.tool && !repeats) return;
  if (walk.is_plunged || walk.piece) {
    return walk.reporter.report(Code::ContourUnclosed, block, "a T0 line before the tool change");
  }
  walk.machine_at_mm.reset();
  walk.tool = walk.layout.taken_tool(*order.tool);
  walk.emitter.take(block.line, {*walk.tool, std::nullopt});
}

void function(Walk& walk, int line, FunctionKind kind, std::string_view text, bool is_at_place) {
  walk.emitter.put(line,
                   Function{.kind = kind,
                            .text = text,
                            .tool = 0,
                            .next_tool = std::nullopt,
                            .is_at_place = is_at_place});
}

void stop_at_place(Walk& walk, int line) {
  walk.emitter.put(line, panelcal::Stop{.kind = StopKind::Optional, .is_at_place = true});
}

/// An event inside a contour waits for the piece that is routed in the same line, M20 and M21 of a
/// pattern for its holes. The manual has no machine functions in contours but M21.
void events_before(Walk& walk, const Block& block, const Order& order) {
  const bool routs = (order.motion || walk.modal.motion || walk.is_routing()) && !order.is_tool_up;
  const bool begins_pattern = order.v || order.nibble == Command::NibbleSlot;
  const auto refuse = [&](std::string expected) {
    walk.reporter.report(Code::ContourUnclosed, block, std::move(expected));
    walk.ended = true;
  };
  if (order.may_stop) {
    if (routs) return refuse("M20 in a T0 line or a drilling line");
    walk.machine_at_mm.reset();  // the machine goes to its zero, or to the line's place
    if (!order.has_xy()) {
      walk.emitter.put(block.line, panelcal::Stop{.kind = StopKind::Optional});
    } else if (!begins_pattern) {
      stop_at_place(walk, block.line);
    }
  }
  if (order.stop && routs && !order.has_xy()) {
    return refuse("M28 and M29 in a rout line with X or Y, or behind the T0 line");
  }
  if (order.text && routs) return refuse("a T0 line before it");
  const auto event = [&](FunctionKind kind, std::string_view text) {
    if (routs) {
      walk.waiting_events.emplace_back(kind, text);
    } else {
      function(walk, block.line, kind, text);
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
        walk.waiting_events.emplace_back(FunctionKind::MachineFunction, "M21");
      } else if (!begins_pattern) {
        if (order.is_tool_up)
          walk.machine_at_mm.reset();  // its coordinate is executed, also in place
        function(walk, block.line, FunctionKind::MachineFunction, "M21", order.has_xy());
      }
      continue;
    }
    if (routs) return refuse("machine functions outside contours");
    walk.machine_at_mm.reset();
    function(walk, block.line, FunctionKind::MachineFunction, code_text(command));
  }
  texts(walk, block, order);
}

void events_after(Walk& walk, const Block& block, const Order& order) {
  if (!order.stop) return;
  if (walk.is_routing()) {
    // The table leaves the contour, so the cutter comes up. How a control goes on without T0, the
    // manual does not say: the motion remains, for such a line to be refused and not to drill.
    const std::optional<Command> motion = walk.modal.motion;
    end_contour(walk, block.line);
    walk.modal.motion = motion;
  }
  walk.machine_at_mm.reset();
  walk.contour = Contour::None;
  const bool goes_home = *order.stop == Command::MachineZero;
  function(walk,
           block.line,
           goes_home ? FunctionKind::MachineZero : FunctionKind::ParkPosition,
           goes_home ? "M28" : "M29");
}

/// M56 to M58: check areas are the control's, forbidden ones leave holes out.
void area(Walk& walk, const Block& block, const Order& order) {
  if (!move_to(walk, order)) {
    return walk.reporter.report(Code::CoordinateMissing, block, "X#Y# of the area");
  }
  walk.modal.reference = Reference::Area;
  const bool is_ignored = !walk.steps.empty() && !walk.areas_in_copies.value_or(true);
  if (!walk.obeys_areas && !is_ignored && !std::exchange(walk.warned_areas, true)) {
    walk.reporter.report(Code::AreasAssumed,
                         block,
                         "M49,PRGM,C or M49,PRGM,-C, or [program] obeys_areas in machine.toml");
  }
  walk.contour = Contour::None;
  if (!walk.obeys_areas.value_or(true)) return;
  if (*order.area != Command::ForbiddenArea) return check_area(walk, block, order);
  if (is_ignored) return;
  constexpr std::size_t kMostAreas = 99;
  if (!order.rounding_mm || *order.rounding_mm <= 0) {
    return walk.reporter.report(Code::ArgumentInvalid, block, "M58D# with the edge's length");
  }
  note_scaling(walk, block.line);
  const auto center = walk.place.placement(position_mm<frame::Programmed>(walk.modal.at_mm));
  const double half_mm = *order.rounding_mm / 2;
  const bool is_known = std::ranges::any_of(walk.areas, [&](const ForbiddenArea& known) {
    return known.center == center && known.half_mm == half_mm;
  });
  if (is_known) return;
  if (walk.areas.size() == kMostAreas) {
    return walk.reporter.report(Code::ArgumentInvalid, block, "at most 99 forbidden areas");
  }
  walk.areas.push_back({center, half_mm});
  // Without a text: the holes are left out already, and the control must not omit others.
  function(walk, block.line, FunctionKind::ForbiddenArea, {});
}

}  // namespace panelcal::sieb_meyer
