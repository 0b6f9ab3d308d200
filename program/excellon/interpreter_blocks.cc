// SPDX-License-Identifier: Apache-2.0
// What the single blocks of a program do; interpreter.cc decides which block comes when.
#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "panelcal/program/excellon/interpreter.h"

namespace panelcal::excellon {
namespace {

std::string text_of(const Word& word) {
  return word.letter + std::string(word.number);
}

template <class T>
bool differs(const std::optional<T>& body, const std::optional<T>& header) {
  return body && header && *body != *header;
}

}  // namespace

// --- helpers -----------------------------------------------------------------------------------

void Interpreter::report(Code code, const Block& block, const Word& word, std::string expected) {
  reporter_.report(code,
                   block.line,
                   word.column,
                   quoted(text_of(word)) + " in " + quoted(block.text),
                   std::move(expected));
}

bool Interpreter::is_alone(const Block& block, std::size_t n_words) {
  if (block.n_words <= n_words) return true;
  report(Code::BlockNotAlone,
         block,
         block.words[n_words],
         quoted(text_of(block.words[0])) + " in a block by itself");
  return false;
}

/// Counts one more; ends the walk above the limit.
bool Interpreter::count(std::int64_t& n, std::int64_t limit, std::string_view things, int line) {
  if (++n <= limit) return true;
  if (!std::exchange(ended_, true)) {
    reporter_.report(Code::TooManyOperations,
                     line,
                     0,
                     fmt::format("more than {} {}", limit, things),
                     "a shorter program, or a higher limit");
  }
  return false;
}

bool Interpreter::count_operation(int line) {
  return count(n_operations_, options_.max_operations, "operations", line);
}

bool Interpreter::count_target(int line) {
  return count(n_targets_, options_.max_measurements, "targets", line);
}

/// Lines need not operate: without this a pattern of comments could be repeated for ever.
void Interpreter::count_idle_line(int line) {
  count(
      n_idle_lines_, options_.max_operations, "lines of step and repeat that drill nothing", line);
}

void Interpreter::put(int line, decltype(Operation::what) what) {
  if (count_operation(line) && sink_ != nullptr) sink_->put({line, path_, std::move(what)});
}

bool Interpreter::read_coordinates(const Block& block,
                                   std::span<const Word> words,
                                   std::array<std::optional<double>, 2>& xy_mm) {
  for (const Word& word : words) {
    if (word.letter != 'X' && word.letter != 'Y') {
      const auto number = parse_count(word.number);
      const auto command = number ? find_command(word.letter, *number) : std::nullopt;
      if (command && !info(*command).runs) {
        reporter_.report(Code::NotSupported,
                         block.line,
                         word.column,
                         quoted(text_of(word)) + " (" + std::string(info(*command).section) +
                             ") is not supported yet");
      } else {
        report(Code::BlockNotAlone, block, word, "only X and Y here");
      }
      return false;
    }
    std::optional<double>& axis_mm = xy_mm[word.letter - 'X'];
    if (axis_mm) {
      report(Code::ArgumentInvalid, block, word, "each axis once");
      return false;
    }
    const ParsedLength parsed = parse_length(word.number, format_);
    if (parsed.fault != NumberFault::None) {
      reporter_.report_number(parsed.fault, word.number, block.line, word.column + 1, format_);
      return false;
    }
    axis_mm = parsed.value.in_mm();
    const bool needs_format =
        word.number.find('.') == std::string_view::npos && !word.number.empty();
    if (needs_format && !warned_format_ && !program_.header.states_format && sink_ == nullptr) {
      warned_format_ = true;
      reporter_.report(Code::FormatAssumed,
                       block.line,
                       word.column,
                       quoted(text_of(word)) + " is read as " + format_.summary(),
                       "INCH or METRIC with LZ or TZ in the header");
    }
  }
  return true;
}

/// Moves the programmed position. An omitted axis stays where the last coordinate of the same kind
/// left it; across the two kinds the machine's two passes would differ, so that is refused.
bool Interpreter::move_to(const Block& block,
                          const std::array<std::optional<double>, 2>& xy_mm,
                          AxisUser user) {
  for (int axis = 0; axis < 2; ++axis) {
    const AxisUser before = modal_.user[axis];
    const bool is_fresh = before == AxisUser::None || before == user ||
                          (before == AxisUser::Cleared && modal_.incremental);
    const bool depends_on_before = modal_.incremental || !xy_mm[axis];
    if (depends_on_before && !is_fresh) {
      reporter_.report(Code::AxisAmbiguous,
                       block.line,
                       block.column,
                       fmt::format("{} takes {} from {}",
                                   quoted(block.text),
                                   axis == 0 ? 'X' : 'Y',
                                   before == AxisUser::Cleared  ? "before the M08"
                                   : before == AxisUser::Target ? "a vision target"
                                                                : "a hole"),
                       "absolute X and Y in this block");
      return false;
    }
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (modal_.incremental) {
      modal_.at_mm[axis] += xy_mm[axis].value_or(0);
    } else if (xy_mm[axis]) {
      modal_.at_mm[axis] = *xy_mm[axis];
    }
    modal_.user[axis] = user;
  }
  has_motion_ = true;
  return true;
}

Position<frame::Nominal> Interpreter::nominal_here() const {
  return placement_(position_mm<frame::Programmed>(modal_.at_mm));
}

// --- holes -------------------------------------------------------------------------------------

void Interpreter::drill_coordinate(const Block& block) {
  std::array<std::optional<double>, 2> xy_mm;
  if (!read_coordinates(block, block.all(), xy_mm)) return;
  if (!move_to(block, xy_mm, AxisUser::Hole)) return;
  drill_modal(block.line);
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
  std::array<std::optional<double>, 2> step_mm;
  if (!read_coordinates(block, block.all().subspan(1), step_mm)) return;
  if (!modal_.has_hole || modal_.user[0] != AxisUser::Hole) {
    return report(Code::RepeatWithoutHole, block, repeat, "a hole to repeat from");
  }
  const Eigen::Vector2d step(step_mm[0].value_or(0), step_mm[1].value_or(0));
  const Eigen::Vector2d start_mm = modal_.at_mm;
  for (int i = 1; i <= *count && !ended_; ++i) {
    modal_.at_mm = start_mm + i * step;
    drill_modal(block.line);
  }
}

bool Interpreter::has_tool(int line) {
  if (tool_ && *tool_ > 0) return true;
  if (!std::exchange(reported_no_tool_, true)) {
    reporter_.report(Code::ToolMissing,
                     line,
                     1,
                     tool_ ? "a hole comes while no tool is taken, after T0"
                           : "a hole comes before any tool was taken",
                     "T#");
  }
  return false;
}

void Interpreter::drill_modal(int line) {
  modal_.has_hole = true;
  if (!count_operation(line)) return;
  if (!vision_.is_ready_to_drill(line) || !has_tool(line) || sink_ == nullptr) return;
  const Position<frame::Nominal> nominal = nominal_here();
  drill(line, nominal, vision_.corrections().actual_from_nominal()(nominal));
}

void Interpreter::drill(int line,
                        const Position<frame::Nominal>& nominal,
                        const PositionEstimate<frame::Actual>& corrected) {
  const Position<frame::Machine> actual =
      work_zero_ + displacement_mm<frame::Machine>(corrected.position.in_mm());
  sink_->put({line, path_, Drill{*tool_, nominal, corrected.position, actual, corrected.cov}});
}

// --- vision ------------------------------------------------------------------------------------

void Interpreter::measure(const Block& block, Command command) {
  std::array<std::optional<double>, 2> xy_mm;
  if (!read_coordinates(block, block.all().subspan(1), xy_mm)) return;
  if (!xy_mm[0] && !xy_mm[1]) {
    return report(Code::CoordinateMissing, block, block.words[0], "X and Y of the target");
  }
  if (!move_to(block, xy_mm, AxisUser::Target) || !count_target(block.line)) return;
  const TargetPlace target{command, block.line, path_, nominal_here(), placement_, work_zero_};
  if (command != Command::HoleAtTarget && command != Command::NestedHoleAtTarget) {
    vision_.measure_target(target);
    return;
  }
  modal_.has_hole = false;
  if (!has_tool(block.line)) return;
  const auto seen = vision_.measure_hole(target);
  if (seen && count_operation(block.line) && sink_ != nullptr) {
    drill(block.line, target.nominal, *seen);
  }
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
  switch (command) {
    case Command::StoreCorrections:
      return vision_.store_under(*number);
    case Command::RewindCorrections:
      return vision_.rewind(block, *number);
    default:
      return vision_.advance(block, *number, placement_);
  }
}

// --- tools, zero, units, end -------------------------------------------------------------------

void Interpreter::select_tool(const Block& block) {
  const auto read = read_tool_block(block, format_, &program_.header.tools, reporter_);
  if (!read) return;
  tool_ = read->tool.number;
  put(block.line, ToolChange{ruled_by_header(block, read->tool), read->compensation_index});
}

/// The header's tool data rule over the body's (CNC-7 manual, Keyboard and Header Commands vs. Body
/// Commands).
Tool Interpreter::ruled_by_header(const Block& block, const Tool& tool) {
  const auto defined = program_.header.tools.find(tool.number);
  if (defined == program_.header.tools.end()) {
    const bool is_bare = tool == Tool{.number = tool.number};
    if (tool.number > 0 && is_bare && !program_.header.tools.empty() && sink_ == nullptr &&
        undefined_tools_.insert(tool.number).second) {
      report(Code::ToolUndefined, block, block.words[0], "a tool that the header defines");
    }
    return tool;
  }
  const Tool& header = defined->second;
  const bool contradicts =
      differs(tool.diameter, header.diameter) || differs(tool.infeed, header.infeed) ||
      differs(tool.retract, header.retract) || differs(tool.speed, header.speed) ||
      differs(tool.max_hits, header.max_hits) || differs(tool.depth_offset, header.depth_offset);
  if (contradicts && sink_ == nullptr) {
    report(Code::ToolDataIgnored, block, block.words[0], "the header's data, which are used");
  }
  Tool ruled = header;
  if (!ruled.diameter) ruled.diameter = tool.diameter;
  if (!ruled.infeed) ruled.infeed = tool.infeed;
  if (!ruled.retract) ruled.retract = tool.retract;
  if (!ruled.speed) ruled.speed = tool.speed;
  if (!ruled.max_hits) ruled.max_hits = tool.max_hits;
  if (!ruled.depth_offset) ruled.depth_offset = tool.depth_offset;
  return ruled;
}

void Interpreter::set_zero(const Block& block) {
  std::array<std::optional<double>, 2> xy_mm;
  if (!read_coordinates(block, block.all().subspan(1), xy_mm)) return;
  if (!xy_mm[0] || !xy_mm[1]) {
    return report(Code::CoordinateMissing, block, block.words[0], "G93X#Y#");
  }
  if (in_pattern_) {
    return report(Code::CommandMisplaced, block, block.words[0], "G93 outside step and repeat");
  }
  if (!vision_.is_unused()) {
    return report(
        Code::ZeroSetUnderCorrection, block, block.words[0], "G93 before the first target");
  }
  const auto zero_set = displacement_mm<frame::Machine>(*xy_mm[0], *xy_mm[1]);
  work_zero_ = options_.absolute_zero +
               displacement_mm<frame::Machine>(options_.work_zero.in_mm()) + zero_set;
  put(block.line, ZeroSet{zero_set, work_zero_});
}

/// M71, M72: only before anything moved, since they change what numbers mean.
void Interpreter::set_unit(const Block& block, LengthUnit unit) {
  warned_format_ = true;
  if (unit == format_.unit) return;
  if (has_motion_ || in_pattern_) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  "the unit before the first coordinate and outside step and repeat");
  }
  format_.unit = unit;
  if (program_.header.states_digits) return;
  format_.integer_digits = unit == LengthUnit::Inch ? 2 : 3;
  format_.decimal_digits = unit == LengthUnit::Inch ? 4 : 3;
}

/// M00(X#Y#), M30(X#Y#): the place is relative to absolute zero.
void Interpreter::end_program(const Block& block, std::span<const Word> words, StopKind kind) {
  if (in_pattern_) {
    return report(Code::CommandMisplaced, block, block.words[0], "M01 and M08 before the end");
  }
  std::array<std::optional<double>, 2> xy_mm;
  if (!read_coordinates(block, words, xy_mm)) return;
  Stop stop{.kind = kind};
  if (xy_mm[0] || xy_mm[1]) {
    stop.from_absolute_zero =
        displacement_mm<frame::Machine>(xy_mm[0].value_or(0), xy_mm[1].value_or(0));
    stop.actual = options_.absolute_zero + *stop.from_absolute_zero;
  }
  vision_.end_program(block.line);
  put(block.line, stop);
  ended_ = true;
  has_end_ = true;
}

}  // namespace panelcal::excellon
