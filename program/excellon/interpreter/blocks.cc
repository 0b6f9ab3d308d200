// SPDX-License-Identifier: Apache-2.0
// Numbers of a block, and the effect of holes and targets.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "program/excellon/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

bool read_word(Walk& walk, const Block& block, const Word& word, MotionWords& out) {
  if (word.letter == 'F') {
    walk.has_dimension = true;
    return read_rate(
        block, word, walk.format(), walk.modal.motion != Motion::Drill, walk.reporter, out.feed);
  }
  std::optional<double>& value_mm = word.letter == 'X'   ? out.xy_mm[0]
                                    : word.letter == 'Y' ? out.xy_mm[1]
                                    : word.letter == 'I' ? out.ij_mm[0]
                                    : word.letter == 'J' ? out.ij_mm[1]
                                    : word.letter == 'A' ? out.radius_mm
                                    : word.letter == 'Z' ? out.depth_mm
                                                         : out.initial_depth_mm;
  if (value_mm) {
    walk.reporter.report(Code::ArgumentInvalid, block.in(word), "each letter once");
    return false;
  }
  const ParsedLength parsed = parse_length(word.number, walk.format());
  if (parsed.fault != NumberFault::None) {
    walk.reporter.report_number(
        parsed.fault, word.number, block.line, word.column + 1, walk.format());
    return false;
  }
  value_mm = parsed.value.in_mm();
  walk.has_dimension = true;
  warn_padded(walk, block, word);
  const auto point = word.number.find('.');
  const double step_mm =
      point == std::string_view::npos
          ? rounding_mm(walk)
          : walk.format().one_unit().in_mm() *
                std::pow(10.0, -static_cast<double>(word.number.size() - point - 1));
  out.step_mm = std::max(out.step_mm, std::min(step_mm, rounding_mm(walk)));
  return true;
}

void drill_modal(Walk& walk, int line) {
  walk.modal.has_hole = true;
  if (!walk.vision.is_ready_to_drill(line) || !has_tool(walk, line)) {
    walk.emitter.count_operations(1, line);
    return;
  }
  walk.emitter.drill(line, walk.modal.at_mm);
}

void keep_target(Walk& walk, const TargetPlace& target) {
  const CorrectionLevel level = level_of(target.command);
  if (target.command == Command::HoleAtTarget || target.command == Command::NestedHoleAtTarget) {
    walk.modal.has_hole = false;
    if (!walk.vision.may_drill_at_target(target) || !has_tool(walk, target.line)) return;
    const DepthOfCut cut = walk.emitter.cut_at(target.line, target.nominal);
    return walk.emitter.put(target.line, TargetHole{level, target.nominal, walk.tool->number, cut});
  }
  const std::vector<Position<frame::Nominal>> targets = walk.vision.take_target(target);
  if (targets.empty()) return;
  const auto n_targets = static_cast<int>(targets.size());
  walk.emitter.put(target.line,
                   VisionSeries{level, targets, walk.vision.fits_otherwise(level, n_targets)});
  const auto keep = walk.vision.keep_series(target, n_targets);
  if (keep) walk.emitter.put(target.line, *keep);
}

}  // namespace

// --- helpers -----------------------------------------------------------------------------------

bool is_alone(Walk& walk, const Block& block, std::size_t n_words) {
  if (block.n_words <= n_words) return true;
  walk.reporter.report(Code::BlockNotAlone,
                       block.in(block.words[n_words]),
                       quoted(block.words[0].text()) + " in a block by itself");
  return false;
}

/// One step of the last digit that the program's format has.
double rounding_mm(const Walk& walk) {
  return (walk.format().one_unit() * std::pow(10.0, -walk.format().decimal_digits)).in_mm();
}

/// Says once that a number has more digits than the format, zeros on its left.
void warn_padded(Walk& walk, const Block& block, const Word& word) {
  if (!has_extra_digits(word.number, walk.format()) || std::exchange(walk.warned_padded, true))
    return;
  walk.reporter.report_padded(word.text(), block.line, word.column, walk.format());
}

bool read_words(Walk& walk,
                const Block& block,
                std::span<const Word> words,
                std::string_view letters,
                MotionWords& out) {
  for (const Word& word : words) {
    if (letters.find(word.letter) == std::string_view::npos) {
      std::string expected = "only ";
      for (const char letter : letters) {
        if (letter != letters.front()) expected += letter == letters.back() ? " and " : ", ";
        expected += letter;
      }
      walk.reporter.report(Code::BlockNotAlone, block.in(word), expected + " here");
      return false;
    }
    if (!read_word(walk, block, word, out)) return false;
  }
  return true;
}

/// Moves the programmed position. An omitted axis stays where the last coordinate of the same kind
/// left it; across the two kinds the machine's two passes would differ, so that is refused, and so
/// is an axis that comes from outside of a pattern.
bool move_to(Walk& walk,
             const Block& block,
             const std::array<std::optional<double>, 2>& xy_mm,
             AxisUser user) {
  if (walk.steps_comment && !agrees_with_comment(walk, block)) return false;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const AxisUser before = walk.modal.user[axis];
    const bool is_fresh = before == AxisUser::None || before == user ||
                          (before == AxisUser::Cleared && walk.modal.incremental);
    const bool depends_on_before = walk.modal.incremental || !xy_mm[axis];
    const bool is_from_outside = walk.modal.begins_pattern && !walk.modal.incremental;
    if (depends_on_before && (!is_fresh || is_from_outside)) {
      walk.reporter.report(
          Code::AxisAmbiguous,
          block,
          fmt::format(" takes {} from {}",
                      axis == 0 ? 'X' : 'Y',
                      before == AxisUser::Cleared  ? "before the M08"
                      : before == AxisUser::Lost   ? "before a P#, G93, M99 or a stop with a place"
                      : is_from_outside            ? "before the pattern"
                      : before == AxisUser::Target ? "a vision target"
                                                   : "a hole or rout move"),
          "absolute X and Y in this block");
      return false;
    }
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double& at_mm = walk.modal.at_mm[static_cast<Eigen::Index>(axis)];
    if (walk.modal.incremental) {
      at_mm += xy_mm[axis].value_or(0);
    } else if (xy_mm[axis]) {
      at_mm = *xy_mm[axis];
    }
    walk.modal.user[axis] = user;
  }
  walk.modal.begins_pattern = false;
  walk.has_motion = true;
  return true;
}

// --- holes -------------------------------------------------------------------------------------

/// A block that begins with X or Y: a hole, a rout move, a corner that a cycle waits for, or a
/// cycle with its code in the middle.
void coordinate(Walk& walk, const Block& block) {
  if (walk.pending) return take_corner(walk, block);
  for (std::size_t i = 1; i < block.n_words; ++i) {
    const auto code = walk.command(block.words[i]);
    if (code == Command::CannedCircle || code == Command::CannedSlot ||
        code == Command::RoutedStepSlot) {
      return inline_cycle(walk, block, i, *code);
    }
  }
  if (walk.modal.motion != Motion::Drill) return move_or_rout(walk, block, block.all());
  MotionWords words;
  if (!read_words(walk, block, block.all(), "XY", words)) return;
  if (move_to(walk, block, words.xy_mm, AxisUser::Work)) drill_modal(walk, block.line);
}

/// `R#X#Y#`: more holes at equal distances from the last one.
void repeat_hole(Walk& walk, const Block& block) {
  const Word& repeat = block.words[0];
  const auto count = parse_count(repeat.number);
  if (!count || *count < 1 || *count > 9999) {
    return walk.reporter.report(Code::ArgumentInvalid, block.in(repeat), "R1 to R9999");
  }
  if (block.n_words > 1 && block.words[1].letter == 'M') {
    return walk.reporter.report(
        Code::CommandMisplaced, block.in(block.words[1]), "R#M02 between M01 and M08");
  }
  if (block.n_words == 1)
    return walk.reporter.report(Code::CoordinateMissing, block.in(repeat), "R#X#Y#");
  MotionWords words;
  if (!read_words(walk, block, block.all().subspan(1), "XY", words)) return;
  // Behind a refused line no command has the axes, and that line is to blame.
  const bool is_of_work = walk.modal.user[0] == AxisUser::Work ||
                          (walk.modal.user[0] == AxisUser::None && walk.reporter.n_refused() > 0);
  if (!walk.modal.has_hole || !is_of_work || walk.modal.motion != Motion::Drill) {
    return walk.reporter.report(Code::RepeatWithoutHole, block.in(repeat), "a hole to repeat from");
  }
  const Eigen::Vector2d step(words.xy_mm[0].value_or(0), words.xy_mm[1].value_or(0));
  const Eigen::Vector2d start_mm = walk.modal.at_mm;
  for (int i = 1; i <= *count && !walk.has_ended(); ++i) {
    walk.modal.at_mm = start_mm + i * step;
    drill_modal(walk, block.line);
  }
}

bool has_tool(Walk& walk, int line) {
  if (walk.has_working_tool()) return true;
  if (!std::exchange(walk.reported_no_tool, true)) {
    walk.reporter.report(Code::ToolMissing, line, walk.tool ? "T0 was the last" : "", "T#");
  }
  return false;
}

// --- vision ------------------------------------------------------------------------------------

void measure(Walk& walk, const Block& block, Command command) {
  if (refuse_while_plunged(walk, block)) return;
  MotionWords words;
  if (!read_words(walk, block, block.all().subspan(1), "XY", words)) return;
  if (!words.xy_mm[0] && !words.xy_mm[1]) {
    return walk.reporter.report(Code::CoordinateMissing, block.first(), "X and Y of the target");
  }
  if (!move_to(walk, block, words.xy_mm, AxisUser::Target) ||
      !walk.emitter.count_target(block.line))
    return;
  const TargetPlace target{command,
                           block.line,
                           std::string(walk.place.pattern.path),
                           std::string(walk.place.pattern.sha256),
                           walk.place.path,
                           walk.place.placement(position_mm<frame::Programmed>(walk.modal.at_mm)),
                           walk.place.placement,
                           walk.place.work_zero,
                           walk.emitter.n_worked() != walk.n_worked_before};
  if (walk.keeps_structure()) return keep_target(walk, target);
  if (command != Command::HoleAtTarget && command != Command::NestedHoleAtTarget) {
    return walk.vision.measure_target(target);
  }
  walk.modal.has_hole = false;
  const auto seen = walk.vision.measure_hole(target);  // in both walks, whatever the tool
  walk.emitter.stop_after(walk.trial);
  if (seen && has_tool(walk, block.line))
    walk.emitter.drill_at_target(block.line, walk.modal.at_mm, *seen);
}

/// Four views of a large target have no operation of their own.
void select_vision_tool(Walk& walk, const Block& block) {
  if (!is_alone(walk, block)) return;
  walk.vision.select_tool(block, walk.format());
  walk.has_dimension |= block.argument.find(',') != block.argument.npos;  // the views' distance
  if (!walk.keeps_structure()) return;
  if (const auto number = parse_count(block.argument)) {
    walk.emitter.put(block.line, VisionTool{*number});
  } else {
    walk.pass_on(block.line, block.text, SettingKind::Vision);
  }
}

void cancel_correction(Walk& walk, const Block& block, Command command) {
  if (command == Command::CancelBase) {
    walk.vision.cancel_base(block.line);
  } else {
    walk.vision.cancel_nested(block.line);
  }
  if (walk.keeps_structure()) walk.emitter.put(block.line, CancelCorrection{level_of(command)});
}

/// M50,#  M51,#  M52(,#)
void stored_label(Walk& walk, const Block& block, Command command) {
  if (!is_alone(walk, block)) return;
  const bool is_advance = command == Command::AdvanceCorrections;
  std::optional<int> number;
  if (block.argument_column == 0 && is_advance) {
    number = 1;
  } else {
    number = parse_count(block.argument);
  }
  if (!number || (is_advance && *number < 1)) {
    return walk.reporter.report(
        Code::ArgumentInvalid,
        block.first(),
        is_advance ? "M52 or M52,# with a count from 1"
                   : fmt::format("M{},# with the number of a label", info(command).number));
  }
  if (walk.keeps_structure()) {
    const auto stored = walk.vision.keep_stored(block, command, *number);
    if (stored) walk.emitter.put(block.line, *stored);
    return;
  }
  switch (command) {
    case Command::StoreCorrections:
      return walk.vision.store_under(block, *number);
    case Command::RewindCorrections:
      return walk.vision.rewind(block, *number);
    default:
      return walk.vision.advance(
          block, *number, walk.is_in_copies() ? &walk.place.placement : nullptr);
  }
}

/// G39(X#Y#): the order goes through as well, for the machine's own use. Without a place the holes
/// go where [coupon] is free, which only the code that performs it knows.
void autocalibration(Walk& walk, const Block& block) {
  if (refuse_while_plunged(walk, block)) return;
  MotionWords words;
  if (!read_words(walk, block, block.all().subspan(1), "XY", words)) return;
  CalibrationOrder order;
  order.line = block.line;
  order.file = walk.place.pattern.path;
  order.file_sha256 = walk.place.pattern.sha256;
  order.command = "G39";
  order.path = walk.place.path;
  if (!words.xy_mm[0] && !words.xy_mm[1]) {
    const bool is_performed =
        walk.options.has_coupon && walk.options.structure == Structure::Expanded;
    walk.vision.calibrate(std::move(order), block.column, block.text);
    if (is_performed) return walk.pass_on_vision(block.line, block.text);
    return walk.reporter.report(Code::CoordinateMissing,
                                block.first(),
                                "X and Y of the first hole, or a [coupon] in the machine's file");
  }
  if (!move_to(walk, block, words.xy_mm, AxisUser::Target)) return;
  const auto nominal = walk.place.placement(position_mm<frame::Programmed>(walk.modal.at_mm));
  order.first_hole = walk.place.work_zero + displacement_mm<frame::Machine>(nominal.in_mm());
  walk.vision.calibrate(std::move(order), block.column, block.text);
  walk.emitter.autocalibration(block.line, walk.modal.at_mm);
}

}  // namespace panelcal::excellon
