// SPDX-License-Identifier: Apache-2.0
// The optical orders of a line: G30 to G36, G39, M75.
#include <algorithm>
#include <utility>

#include "program/sieb_meyer/interpreter/interpreter.h"

namespace panelcal::sieb_meyer {

TargetPlace Interpreter::target_place(const Block& block, Command command) {
  std::vector<std::int64_t> copies;
  for (const auto& [n, i] : steps_) copies.push_back(n);
  return {command,
          block.line,
          std::string(place_.pattern.path),
          std::string(place_.pattern.sha256),
          place_.path,
          place_.placement(position_mm<frame::Programmed>(modal_.at_mm)),
          place_.placement,
          place_.work_zero,
          std::move(copies)};
}

bool Interpreter::may_drill_target(int line) {
  return has_tool(line) && !is_forbidden(line, modal_.at_mm);
}

void Interpreter::optical_order(const Block& block, const Order& order) {
  const Command command = *order.camera;
  if (modal_.motion || is_routing()) {
    return report(Code::ContourUnclosed, block, quoted(block.text), "a T0 line before it");
  }
  if (pattern_) {
    return report(
        Code::CycleUnfinished, block, panelcal::quoted(pattern_->text), "its second point");
  }
  const bool measures = command == Command::Measure || command == Command::FinishMeasure ||
                        command == Command::MeasureOffset;
  if (measures != order.has_xy()) {
    return report(
        Code::CoordinateMissing,
        block,
        quoted(block.text),
        measures ? "X#Y# of the target" : code_text(command) + " in a line without X and Y");
  }
  contour_ = Contour::None;
  machine_at_mm_.reset();
  move_to(order);
  if (measures && !emitter_.count_target(block.line)) return;
  if (measures && !is_decided(block.line)) return;
  if (keeps_structure()) return keep_optical_order(block, command);
  const TargetPlace target = target_place(block, command);
  switch (command) {
    case Command::Measure:
    case Command::FinishMeasure:
      return optical_.measure(target);
    case Command::MeasureOffset: {
      if (optical_.is_pattern_mode()) return optical_.measure_pattern(target);
      const auto seen = optical_.measure_hole(target);  // in both walks, whatever the tool
      emitter_.stop_after(trial_);
      if (seen && may_drill_target(block.line)) {
        emitter_.set_cut(cut_at(block.line, modal_.at_mm));
        emitter_.drill_at_target(block.line, modal_.at_mm, *seen);
        emitter_.set_cut(base_cut_);
      }
      return;
    }
    case Command::CorrectionOn:
      return optical_.calculate(target);
    case Command::CorrectionOff:
      return optical_.turn_off(n_blocks_);
    default:
      return optical_.clear();
  }
}

void Interpreter::camera_text(const Block& block, Command command) {
  if (block.n_words != 1) {
    return report(
        Code::BlockNotAlone, block, quoted(block.text), code_text(command) + " alone in its line");
  }
  contour_ = Contour::None;
  machine_at_mm_.reset();
  if (command == Command::CorrectionValues) {
    if (keeps_structure()) return keep_set(block);
    const bool is_passed =
        optical_.organize(block, step_number(), target_place(block, Command::CorrectionValues));
    if (!is_passed) return;
    return emitter_.put(block.line,
                        Setting{.text = block.text,
                                .kind = SettingKind::Vision,
                                .is_unperformed = optical_.is_unperformed(block.line)});
  }
  if (command == Command::CameraByte) {
    const auto byte = parse_count(block.argument);
    if (!byte || *byte > 255) {
      return reporter_.report(Code::ArgumentInvalid,
                              block.line,
                              block.argument_column,
                              quoted(block.argument),
                              "G35,# with a byte, 0 to 255");
    }
    optical_.select_tool(*byte);
    if (keeps_structure()) return emitter_.put(block.line, VisionTool{*byte});
  }
  emitter_.put(block.line, Setting{block.text, SettingKind::Vision});
}

}  // namespace panelcal::sieb_meyer
