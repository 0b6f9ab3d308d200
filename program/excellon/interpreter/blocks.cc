// SPDX-License-Identifier: Apache-2.0
// Numbers of a block, and the effect of holes and targets.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "program/excellon/interpreter/interpreter.h"
#include <fmt/format.h>

namespace panelcal::excellon {

// --- helpers -----------------------------------------------------------------------------------

void Interpreter::report(Code code, const Block& block, const Word& word, std::string expected) {
  reporter_.report(code,
                   block.line,
                   word.column,
                   quoted(word.text()) + " in " + quoted(block.text),
                   std::move(expected));
}

bool Interpreter::is_alone(const Block& block, std::size_t n_words) {
  if (block.n_words <= n_words) return true;
  report(Code::BlockNotAlone,
         block,
         block.words[n_words],
         quoted(block.words[0].text()) + " in a block by itself");
  return false;
}

/// One step of the last digit that the program's format has.
double Interpreter::rounding_mm() const {
  return (format().one_unit() * std::pow(10.0, -format().decimal_digits)).in_mm();
}

/// Says once that a number has more digits than the format, zeros on its left.
void Interpreter::warn_padded(const Block& block, const Word& word) {
  if (!has_extra_digits(word.number, format()) || std::exchange(warned_padded_, true)) return;
  reporter_.report_padded(word.text(), block.line, word.column, format());
}

bool Interpreter::read_word(const Block& block, const Word& word, MotionWords& out) {
  if (word.letter == 'F') {
    has_dimension_ = true;
    return read_rate(block, word, format(), modal_.motion != Motion::Drill, reporter_, out.feed);
  }
  std::optional<double>& value_mm = word.letter == 'X'   ? out.xy_mm[0]
                                    : word.letter == 'Y' ? out.xy_mm[1]
                                    : word.letter == 'I' ? out.ij_mm[0]
                                    : word.letter == 'J' ? out.ij_mm[1]
                                    : word.letter == 'A' ? out.radius_mm
                                    : word.letter == 'Z' ? out.depth_mm
                                                         : out.initial_depth_mm;
  if (value_mm) {
    report(Code::ArgumentInvalid, block, word, "each letter once");
    return false;
  }
  const ParsedLength parsed = parse_length(word.number, format());
  if (parsed.fault != NumberFault::None) {
    reporter_.report_number(parsed.fault, word.number, block.line, word.column + 1, format());
    return false;
  }
  value_mm = parsed.value.in_mm();
  has_dimension_ = true;
  warn_padded(block, word);
  const auto point = word.number.find('.');
  const double step_mm =
      point == std::string_view::npos
          ? rounding_mm()
          : format().one_unit().in_mm() *
                std::pow(10.0, -static_cast<double>(word.number.size() - point - 1));
  out.step_mm = std::max(out.step_mm, std::min(step_mm, rounding_mm()));
  return true;
}

bool Interpreter::read_words(const Block& block,
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
      report(Code::BlockNotAlone, block, word, expected + " here");
      return false;
    }
    if (!read_word(block, word, out)) return false;
  }
  return true;
}

/// Moves the programmed position. An omitted axis stays where the last coordinate of the same kind
/// left it; across the two kinds the machine's two passes would differ, so that is refused, and so
/// is an axis that comes from outside of a pattern.
bool Interpreter::move_to(const Block& block,
                          const std::array<std::optional<double>, 2>& xy_mm,
                          AxisUser user) {
  if (steps_comment_ && !agrees_with_comment(block)) return false;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const AxisUser before = modal_.user[axis];
    const bool is_fresh = before == AxisUser::None || before == user ||
                          (before == AxisUser::Cleared && modal_.incremental);
    const bool depends_on_before = modal_.incremental || !xy_mm[axis];
    const bool is_from_outside = modal_.begins_pattern && !modal_.incremental;
    if (depends_on_before && (!is_fresh || is_from_outside)) {
      reporter_.report(
          Code::AxisAmbiguous,
          block.line,
          block.column,
          fmt::format("{} takes {} from {}",
                      quoted(block.text),
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
    double& at_mm = modal_.at_mm[static_cast<Eigen::Index>(axis)];
    if (modal_.incremental) {
      at_mm += xy_mm[axis].value_or(0);
    } else if (xy_mm[axis]) {
      at_mm = *xy_mm[axis];
    }
    modal_.user[axis] = user;
  }
  modal_.begins_pattern = false;
  has_motion_ = true;
  return true;
}

// --- holes -------------------------------------------------------------------------------------

/// A block that begins with X or Y: a hole, a rout move, a corner that a cycle waits for, or a
/// cycle with its code in the middle.
void Interpreter::coordinate(const Block& block) {
  if (pending_) return take_corner(block);
  for (std::size_t i = 1; i < block.n_words; ++i) {
    const auto code = command(block.words[i]);
    if (code == Command::CannedCircle || code == Command::CannedSlot ||
        code == Command::RoutedStepSlot) {
      return inline_cycle(block, i, *code);
    }
  }
  if (modal_.motion != Motion::Drill) return move_or_rout(block, block.all());
  MotionWords words;
  if (!read_words(block, block.all(), "XY", words)) return;
  if (move_to(block, words.xy_mm, AxisUser::Work)) drill_modal(block.line);
}

void Interpreter::drill_modal(int line) {
  modal_.has_hole = true;
  if (!vision_.is_ready_to_drill(line) || !has_tool(line)) {
    emitter_.count_operations(1, line);
    return;
  }
  emitter_.drill(line, modal_.at_mm);
}

/// `R#X#Y#`: more holes at equal distances from the last one.
void Interpreter::repeat_hole(const Block& block) {
  const Word& repeat = block.words[0];
  const auto count = parse_count(repeat.number);
  if (!count || *count < 1 || *count > 9999) {
    return report(Code::ArgumentInvalid, block, repeat, "R1 to R9999");
  }
  if (block.n_words > 1 && block.words[1].letter == 'M') {
    return report(Code::CommandMisplaced, block, block.words[1], "R#M02 between M01 and M08");
  }
  if (block.n_words == 1) return report(Code::CoordinateMissing, block, repeat, "R#X#Y#");
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "XY", words)) return;
  // Behind a refused line no command has the axes, and that line is to blame.
  const bool is_of_work = modal_.user[0] == AxisUser::Work ||
                          (modal_.user[0] == AxisUser::None && reporter_.n_refused() > 0);
  if (!modal_.has_hole || !is_of_work || modal_.motion != Motion::Drill) {
    return report(Code::RepeatWithoutHole, block, repeat, "a hole to repeat from");
  }
  const Eigen::Vector2d step(words.xy_mm[0].value_or(0), words.xy_mm[1].value_or(0));
  const Eigen::Vector2d start_mm = modal_.at_mm;
  for (int i = 1; i <= *count && !has_ended(); ++i) {
    modal_.at_mm = start_mm + i * step;
    drill_modal(block.line);
  }
}

bool Interpreter::has_tool(int line) {
  if (has_working_tool()) return true;
  if (!std::exchange(reported_no_tool_, true)) {
    reporter_.report(Code::ToolMissing, line, 1, tool_ ? "T0 was the last" : "", "T#");
  }
  return false;
}

// --- vision ------------------------------------------------------------------------------------

void Interpreter::measure(const Block& block, Command command) {
  if (refuse_while_plunged(block)) return;
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "XY", words)) return;
  if (!words.xy_mm[0] && !words.xy_mm[1]) {
    return report(Code::CoordinateMissing, block, block.words[0], "X and Y of the target");
  }
  if (!move_to(block, words.xy_mm, AxisUser::Target) || !emitter_.count_target(block.line)) return;
  const TargetPlace target{command,
                           block.line,
                           std::string(place_.pattern.path),
                           std::string(place_.pattern.sha256),
                           place_.path,
                           place_.placement(position_mm<frame::Programmed>(modal_.at_mm)),
                           place_.placement,
                           place_.work_zero};
  if (keeps_structure()) return keep_target(target);
  if (command != Command::HoleAtTarget && command != Command::NestedHoleAtTarget) {
    return vision_.measure_target(target);
  }
  modal_.has_hole = false;
  const auto seen = vision_.measure_hole(target);  // in both walks, whatever the tool
  emitter_.stop_after(trial_);
  if (seen && has_tool(block.line)) emitter_.drill_at_target(block.line, modal_.at_mm, *seen);
}

void Interpreter::keep_target(const TargetPlace& target) {
  const CorrectionLevel level = level_of(target.command);
  if (target.command == Command::HoleAtTarget || target.command == Command::NestedHoleAtTarget) {
    modal_.has_hole = false;
    if (!vision_.may_drill_at_target(target) || !has_tool(target.line)) return;
    const DepthOfCut cut = emitter_.cut_at(target.line, target.nominal);
    return emitter_.put(target.line, TargetHole{level, target.nominal, tool_->number, cut});
  }
  const std::vector<Position<frame::Nominal>> targets = vision_.take_target(target);
  if (targets.empty()) return;
  const auto n_targets = static_cast<int>(targets.size());
  emitter_.put(target.line, VisionSeries{level, targets, vision_.fits_otherwise(level, n_targets)});
  const auto keep = vision_.keep_series(target, n_targets);
  if (keep) emitter_.put(target.line, *keep);
}

/// Four views of a large target have no operation of their own.
void Interpreter::select_vision_tool(const Block& block) {
  if (!is_alone(block)) return;
  vision_.select_tool(block, format());
  has_dimension_ |= block.arguments.find(',') != block.arguments.npos;  // the views' distance
  if (!keeps_structure()) return;
  if (const auto number = parse_count(block.arguments)) {
    emitter_.put(block.line, VisionTool{*number});
  } else {
    pass_on(block.line, block.text, SettingKind::Vision);
  }
}

void Interpreter::cancel_correction(const Block& block, Command command) {
  if (command == Command::CancelBase) {
    vision_.cancel_base(block.line);
  } else {
    vision_.cancel_nested(block.line);
  }
  if (keeps_structure()) emitter_.put(block.line, CancelCorrection{level_of(command)});
}

/// M50,#  M51,#  M52(,#)
void Interpreter::stored_label(const Block& block, Command command) {
  if (!is_alone(block)) return;
  const bool is_advance = command == Command::AdvanceCorrections;
  std::optional<int> number;
  if (block.arguments_column == 0 && is_advance) {
    number = 1;
  } else {
    number = parse_count(block.arguments);
  }
  if (!number || (is_advance && *number < 1)) {
    return report(Code::ArgumentInvalid,
                  block,
                  block.words[0],
                  is_advance
                      ? "M52 or M52,# with a count from 1"
                      : fmt::format("M{},# with the number of a label", info(command).number));
  }
  if (keeps_structure()) {
    const auto stored = vision_.keep_stored(block, command, *number);
    if (stored) emitter_.put(block.line, *stored);
    return;
  }
  switch (command) {
    case Command::StoreCorrections:
      return vision_.store_under(block, *number);
    case Command::RewindCorrections:
      return vision_.rewind(block, *number);
    default:
      return vision_.advance(
          block, *number, in_pattern_ || in_stored_pattern_ ? &place_.placement : nullptr);
  }
}

/// G39(X#Y#): the order goes through as well, for the machine's own use. Without a place the holes
/// go where [coupon] is free, which only the code that performs it knows.
void Interpreter::autocalibration(const Block& block) {
  if (refuse_while_plunged(block)) return;
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "XY", words)) return;
  CalibrationOrder order;
  order.line = block.line;
  order.file = place_.pattern.path;
  order.file_sha256 = place_.pattern.sha256;
  order.command = "G39";
  order.path = place_.path;
  if (!words.xy_mm[0] && !words.xy_mm[1]) {
    const bool is_performed = options_.has_coupon && options_.structure == Structure::Expanded;
    vision_.calibrate(std::move(order), block.column, block.text);
    if (is_performed) return pass_on_vision(block.line, block.text);
    return report(Code::CoordinateMissing,
                  block,
                  block.words[0],
                  "X and Y of the first hole, or a [coupon] in the machine's file");
  }
  if (!move_to(block, words.xy_mm, AxisUser::Target)) return;
  const auto nominal = place_.placement(position_mm<frame::Programmed>(modal_.at_mm));
  order.first_hole = place_.work_zero + displacement_mm<frame::Machine>(nominal.in_mm());
  vision_.calibrate(std::move(order), block.column, block.text);
  emitter_.autocalibration(block.line, modal_.at_mm);
}

}  // namespace panelcal::excellon
