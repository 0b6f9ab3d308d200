// SPDX-License-Identifier: Apache-2.0
// The optical orders of a line: G30 to G36, G39, M75.
#include <utility>

#include "program/sieb_meyer/interpreter/parts.h"

namespace panelcal::sieb_meyer {

TargetPlace target_place(Walk& walk, const Block& block, Command command) {
  std::vector<std::int64_t> copies;
  for (const auto& [n, i] : walk.steps) copies.push_back(n);
  return {command,
          block.line,
          std::string(walk.place.pattern.path),
          std::string(walk.place.pattern.sha256),
          walk.place.path,
          walk.place.placement(position_mm<frame::Programmed>(walk.modal.at_mm)),
          walk.place.placement,
          walk.place.work_zero,
          std::move(copies)};
}

bool may_drill_target(Walk& walk, int line) {
  return has_tool(walk, line) && !is_forbidden(walk, line, walk.modal.at_mm);
}

void optical_order(Walk& walk, const Block& block, const Order& order) {
  const Command command = *order.camera;
  if (refuse_in_contour(walk, block) || refuse_open_pattern(walk, block)) return;
  const bool measures = command == Command::Measure || command == Command::FinishMeasure ||
                        command == Command::MeasureOffset;
  if (measures != order.has_xy()) {
    return walk.reporter.report(
        Code::CoordinateMissing,
        block,
        measures ? "X#Y# of the target" : code_text(command) + " in a line without X and Y");
  }
  walk.contour = Contour::None;
  walk.machine_at_mm.reset();
  move_to(walk, order);
  if (measures && !walk.emitter.count_target(block.line)) return;
  if (measures && !is_decided(walk, block.line)) return;
  if (walk.keeps_structure()) return keep_optical_order(walk, block, command);
  const TargetPlace target = target_place(walk, block, command);
  switch (command) {
    case Command::Measure:
    case Command::FinishMeasure:
      return walk.optical.measure(target);
    case Command::MeasureOffset: {
      if (walk.optical.is_pattern_mode()) return walk.optical.measure_pattern(target);
      const auto seen = walk.optical.measure_hole(target);  // in both walks, whatever the tool
      walk.emitter.stop_after(walk.trial);
      if (seen && may_drill_target(walk, block.line)) {
        walk.emitter.set_cut(cut_at(walk, block.line, walk.modal.at_mm));
        walk.emitter.drill_at_target(block.line, walk.modal.at_mm, *seen);
        walk.emitter.set_cut(walk.base_cut);
      }
      return;
    }
    case Command::CorrectionOn:
      return walk.optical.calculate(target);
    case Command::CorrectionOff:
      return walk.optical.turn_off(walk.n_blocks);
    default:
      return walk.optical.clear();
  }
}

void camera_text(Walk& walk, const Block& block, Command command) {
  if (block.n_words != 1) {
    return walk.reporter.report(
        Code::BlockNotAlone, block, code_text(command) + " alone in its line");
  }
  walk.contour = Contour::None;
  walk.machine_at_mm.reset();
  if (command == Command::CorrectionValues) {
    if (walk.keeps_structure()) return keep_set(walk, block);
    const bool is_passed = walk.optical.organize(
        block, step_number(walk), target_place(walk, block, Command::CorrectionValues));
    if (!is_passed) return;
    return walk.emitter.put(block.line,
                            Setting{.text = block.text,
                                    .kind = SettingKind::Vision,
                                    .is_unperformed = walk.optical.is_unperformed(block.line)});
  }
  if (command == Command::CameraByte) {
    const auto byte = parse_count(block.argument);
    if (!byte || *byte > 255) {
      return walk.reporter.report(
          Code::ArgumentInvalid, block.of_argument(), "G35,# with a byte, 0 to 255");
    }
    walk.optical.select_tool(*byte);
    if (walk.keeps_structure()) return walk.emitter.put(block.line, VisionTool{*byte});
  }
  walk.emitter.put(block.line, Setting{block.text, SettingKind::Vision});
}

}  // namespace panelcal::sieb_meyer
