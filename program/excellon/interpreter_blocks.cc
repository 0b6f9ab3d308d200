// SPDX-License-Identifier: Apache-2.0
// What the blocks of holes, targets, tools, zeros and stops do.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "panelcal/program/excellon/interpreter.h"

namespace panelcal::excellon {
namespace {

/// Drops what the header says itself; true if it says something else.
template <class T>
bool leave_to(const std::optional<T>& header, std::optional<T>& said) {
  const bool contradicts = header && said && *header != *said;
  if (header) said.reset();
  return contradicts;
}

bool leave_to(const Tool& header, bool body_has_rates, Tool& said) {
  bool contradicts = leave_to(header.diameter, said.diameter);
  contradicts |= leave_to(header.max_hits, said.max_hits);
  contradicts |= leave_to(header.depth_offset, said.depth_offset);
  if (body_has_rates) return contradicts;
  contradicts |= leave_to(header.infeed, said.infeed);
  contradicts |= leave_to(header.retract, said.retract);
  contradicts |= leave_to(header.speed, said.speed);
  return contradicts;
}

template <class T>
void fill(std::optional<T>& ruling, const std::optional<T>& other) {
  if (!ruling) ruling = other;
}

/// Takes from `other` what `ruling` does not say.
void fill_all(Tool& ruling, const Tool& other) {
  fill(ruling.diameter, other.diameter);
  fill(ruling.infeed, other.infeed);
  fill(ruling.retract, other.retract);
  fill(ruling.speed, other.speed);
  fill(ruling.max_hits, other.max_hits);
  fill(ruling.depth_offset, other.depth_offset);
}

}  // namespace

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
  return (format_.one_unit() * std::pow(10.0, -format_.decimal_digits)).in_mm();
}

/// Says once that a number is read by an assumption: the unit, or the zeros that are left off.
void Interpreter::warn_format(const Block& block, const Word& word) {
  if (warned_format_ || word.number.empty() || word.number.find('.') != std::string_view::npos) {
    return;
  }
  const auto n_digits =
      std::ranges::count_if(word.number, [](char c) { return c >= '0' && c <= '9'; });
  const bool is_full = n_digits == format_.integer_digits + format_.decimal_digits;
  const bool knows_zeros = program_.header.states_zeros || is_full;
  if (states_unit_ && knows_zeros) return;
  warned_format_ = true;
  reporter_.report(Code::FormatAssumed,
                   block.line,
                   word.column,
                   quoted(word.text()) + " is read as " + format_.summary(),
                   "INCH or METRIC with LZ or TZ in the header");
}

bool Interpreter::read_word(const Block& block, const Word& word, MotionWords& out) {
  if (word.letter == 'F') {
    return read_rate(block, word, format_, modal_.motion != Motion::Drill, reporter_, out.feed);
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
  const ParsedLength parsed = parse_length(word.number, format_);
  if (parsed.fault != NumberFault::None) {
    reporter_.report_number(parsed.fault, word.number, block.line, word.column + 1, format_);
    return false;
  }
  value_mm = parsed.value.in_mm();
  warn_format(block, word);
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
/// left it; across the two kinds the machine's two passes would differ, so that is refused.
bool Interpreter::move_to(const Block& block,
                          const std::array<std::optional<double>, 2>& xy_mm,
                          AxisUser user) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
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
  if (!modal_.has_hole || modal_.user[0] != AxisUser::Work || modal_.motion != Motion::Drill) {
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
  if (tool_ && tool_->number > 0) return true;
  if (!std::exchange(reported_no_tool_, true)) {
    reporter_.report(Code::ToolMissing,
                     line,
                     1,
                     tool_ ? "a hole or rout move comes while no tool is taken, after T0"
                           : "a hole or rout move comes before any tool was taken",
                     "T#");
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
                           std::string(place_.file),
                           place_.path,
                           place_.placement(position_mm<frame::Programmed>(modal_.at_mm)),
                           place_.placement,
                           place_.work_zero};
  if (command != Command::HoleAtTarget && command != Command::NestedHoleAtTarget) {
    return vision_.measure_target(target);
  }
  modal_.has_hole = false;
  if (!has_tool(block.line)) return;
  const auto seen = vision_.measure_hole(target);
  if (seen) emitter_.drill_at_target(block.line, modal_.at_mm, *seen);
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
      return vision_.advance(block, *number, place_.placement);
  }
}

/// G39 belongs to the machine's own calibration; the order goes through in its place.
void Interpreter::autocalibration(const Block& block) {
  if (refuse_while_plunged(block)) return;
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "XY", words)) return;
  if (is_first_walk()) {
    reporter_.report(Code::CalibrationNotPerformed,
                     block.line,
                     block.column,
                     quoted(block.text) + " is passed on, not performed");
  }
  emitter_.put(block.line, Setting{block.text});
}

// --- tools -------------------------------------------------------------------------------------

void Interpreter::select_tool(const Block& block) {
  if (refuse_while_plunged(block)) return;
  const auto read = read_tool_block(
      block, {format_, &program_.header.tools, program_.reading.diameter_page}, reporter_);
  if (!read) return;
  tool_ = known_tool(block, *read);
  compensation_index_ = read->compensation_index;
  emitter_.take(block.line, {*tool_, read->compensation_index});
}

/// Everything that is known of the tool of a block: what the block and earlier blocks say, and the
/// header, which rules, unless OM48 or, for rates, G07 says otherwise.
/// Source CNC-7 manual, Keyboard and Header Commands vs. Body Commands
Tool Interpreter::known_tool(const Block& block, const ToolBlock& read) {
  const int number = read.tool.number;
  const auto defined = program_.header.tools.find(number);
  const bool is_defined = defined != program_.header.tools.end();
  const bool is_bare = read.tool == Tool{.number = number};
  if (number > 0 && !is_defined && is_bare && !program_.header.tools.empty() && is_first_walk() &&
      undefined_tools_.insert(number).second) {
    report(Code::ToolUndefined, block, block.words[0], "a tool that the header defines");
  }
  Tool& body = body_tools_[number];
  if (read.turns_hits_off) body.max_hits.reset();
  Tool said = read.tool;
  const Tool header = is_defined ? defined->second : Tool{.number = number};
  if (!body_rules_) {
    const bool contradicts = leave_to(header, body_rates_, said);
    if (contradicts && is_first_walk()) {
      report(Code::ToolDataIgnored, block, block.words[0], "the header's data, which are used");
    }
  }
  fill_all(said, body);
  body = said;
  fill_all(said, header);
  return said;
}

/// F# or B# in a block of its own: the table's feed in rout mode, else the tool's.
void Interpreter::rate(const Block& block) {
  const Word& word = block.words[0];
  if (!is_alone(block)) return;
  const bool is_table = word.letter == 'F' && modal_.motion != Motion::Drill;
  std::optional<Feed> read;
  if (!read_rate(block, word, format_, is_table, reporter_, read)) return;
  if (is_table) {
    modal_.feed = read;
    return;
  }
  if (!tool_ || tool_->number == 0) {
    return report(Code::ToolMissing, block, word, "T# before it: the rate is the tool's");
  }
  const auto defined = program_.header.tools.find(tool_->number);
  const bool body_wins = body_rules_ || body_rates_ || defined == program_.header.tools.end() ||
                         !(word.letter == 'F' ? defined->second.infeed : defined->second.retract);
  if (!body_wins) {
    if (is_first_walk()) {
      report(Code::ToolDataIgnored, block, word, "the header's data, which are used");
    }
    return;
  }
  (word.letter == 'F' ? tool_->infeed : tool_->retract) = read;
  Tool& known = body_tools_[tool_->number];
  (word.letter == 'F' ? known.infeed : known.retract) = read;
  emitter_.put(block.line, Setting{block.text});
}

// --- zero, units -------------------------------------------------------------------------------

void Interpreter::set_zero(const Block& block) {
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "XY", words)) return;
  if (!words.xy_mm[0] || !words.xy_mm[1]) {
    return report(Code::CoordinateMissing, block, block.words[0], "G93X#Y#");
  }
  if (in_pattern_ || in_stored_pattern_) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  "G93 outside step and repeat and stored patterns");
  }
  if (!vision_.is_unused()) {
    return report(
        Code::ZeroSetUnderCorrection, block, block.words[0], "G93 before the first target");
  }
  const auto set = displacement_mm<frame::Programmed>(*words.xy_mm[0], *words.xy_mm[1]);
  const auto zero_set = displacement_mm<frame::Machine>(frame_(set).in_mm());
  const auto correction = program_.header.zero_correction;
  place_.work_zero = options_.absolute_zero +
                     displacement_mm<frame::Machine>(correction ? frame_(*correction).in_mm()
                                                                : options_.work_zero.in_mm()) +
                     zero_set;
  emitter_.put(block.line, ZeroSet{zero_set, place_.work_zero});
}

/// M71, M72: only before anything moved, since they change what numbers mean.
void Interpreter::set_unit(const Block& block, LengthUnit unit) {
  states_unit_ = true;
  if (unit == format_.unit) return;
  if (has_motion_ || in_pattern_) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  "the unit before the first coordinate and outside step and repeat");
  }
  format_.unit = unit;
  if (!program_.header.states_digits) {
    format_.integer_digits = unit == LengthUnit::Inch ? 2 : 3;
    format_.decimal_digits = unit == LengthUnit::Inch ? 4 : 3;
  }
  plain_ = PlainReader(format_);
}

// --- stops, messages, events -------------------------------------------------------------------

/// M00, M06, M09, M30 with (X#Y#): the place is relative to absolute zero.
void Interpreter::stop(const Block& block, std::span<const Word> words, StopKind kind) {
  if (refuse_while_plunged(block)) return;
  MotionWords read;
  if (!read_words(block, words, "XY", read)) return;
  Stop stop{.kind = kind};
  if (read.xy_mm[0] || read.xy_mm[1]) {
    const auto place =
        displacement_mm<frame::Programmed>(read.xy_mm[0].value_or(0), read.xy_mm[1].value_or(0));
    stop.from_absolute_zero = displacement_mm<frame::Machine>(frame_(place).in_mm());
    stop.actual = options_.absolute_zero + *stop.from_absolute_zero;
  }
  emitter_.put(block.line, stop);
}

void Interpreter::end_program(const Block& block, std::span<const Word> words, StopKind kind) {
  if (in_pattern_ || in_stored_pattern_) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  in_pattern_ ? "M01 and M08 before the end" : "the end in the program itself");
  }
  if (refuse_while_plunged(block)) return;
  vision_.end_program(block.line);
  stop(block, words, kind);
  ended_ = true;
  has_end_ = true;
}

/// G04X#: one millisecond per increment of the format; below 1 s, above 10 s or missing is 10 s.
void Interpreter::dwell(const Block& block) {
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "X", words)) return;
  constexpr double kLeast_s = 1;
  constexpr double kMost_s = 10;
  const double time_s = words.xy_mm[0].value_or(0) / rounding_mm() / 1000;
  const bool is_usable = time_s >= kLeast_s - 1e-9 && time_s <= kMost_s + 1e-9;
  emitter_.put(block.line, Dwell{seconds(is_usable ? time_s : kMost_s)});
}

void Interpreter::message(const Block& block) {
  constexpr std::size_t kShown = 20;
  if (!is_alone(block)) return;
  if (block.arguments.size() > kShown && is_first_walk()) {
    reporter_.report(Code::MessageTooLong,
                     block.line,
                     block.arguments_column + static_cast<int>(kShown),
                     quoted(block.arguments),
                     "at most 20 characters, or M45");
  }
  emitter_.put(block.line, Message{block.arguments});
}

/// `M45,text\` goes on in the next lines until one has no backslash at its end.
void Interpreter::long_message(const SourceLine& line) {
  constexpr std::size_t kShown = 78;
  refuse_pending(line.number, "M45");
  std::string text;
  SourceLine part = line;
  part.text.remove_prefix(part.text.find(',') + 1);
  while (true) {
    const bool more = is_continued(part.text);
    const std::string_view shown =
        more ? part.text.substr(0, part.text.find_last_of('\\')) : part.text;
    if (shown.size() > kShown && is_first_walk()) {
      reporter_.report(
          Code::MessageTooLong, part.number, 1, quoted(shown), "at most 78 characters a line");
    }
    text += shown;
    if (!more) break;
    if (cursor_.at_end()) {
      return reporter_.report(Code::ArgumentInvalid,
                              part.number,
                              part.column,
                              quoted(part.text),
                              "one more line behind the backslash");
    }
    text += '\n';
    part = cursor_.next();
  }
  emitter_.put(line.number, Message{text, true});
}

void Interpreter::text_offset(const SourceLine& line) {
  const auto comma = line.text.find(',');
  if (comma == std::string_view::npos) {
    return emitter_.put(line.number, Setting{line.text});  // only shows the offset
  }
  Eigen::Vector2d offset_mm = text_offset_.in_mm();
  const std::string_view value = line.text.substr(comma + 1);
  const auto done = read_text_offset(value, format_, offset_mm);
  if (done) {
    text_offset_ = displacement_mm<frame::Programmed>(offset_mm);
    return;
  }
  reporter_.report(Code::ArgumentInvalid,
                   line.number,
                   line.column + static_cast<int>(comma) + 1,
                   quoted(value),
                   done.error());
}

void Interpreter::function(const Block& block, FunctionKind kind) {
  if (!is_alone(block)) return;
  if (kind == FunctionKind::SpindleGroup && block.arguments != "OFF" &&
      !parse_count(block.arguments)) {
    return report(Code::ArgumentInvalid, block, block.words[0], "M96,# or M96,OFF");
  }
  emitter_.put(block.line, Function{.kind = kind, .text = block.text});
}

/// With [reference_scaling] known the holes come out scaled and the machine must not do it again;
/// without, the order goes to the machine.
void Interpreter::switch_scaling(const Block& block, bool is_on) {
  place_.is_scaled = is_on;
  const bool is_ours = options_.scaling.has_value();
  if (!is_ours && is_on && is_first_walk()) {
    reporter_.report(Code::ScalingUnknown,
                     block.line,
                     block.column,
                     quoted(block.text) + " is passed on to the machine",
                     "[reference_scaling] in machine.toml");
  }
  emitter_.put(block.line,
               Function{.kind = is_on ? FunctionKind::ScalingOn : FunctionKind::ScalingOff,
                        .text = is_ours ? std::string_view() : block.text});
}

}  // namespace panelcal::excellon
