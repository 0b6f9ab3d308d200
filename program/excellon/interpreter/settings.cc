// SPDX-License-Identifier: Apache-2.0
// Tools and their data, zeros and units.
#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "program/excellon/interpreter/interpreter.h"
#include "program/excellon/text/comment_format.h"
#include "program/excellon/text/header_format.h"
#include "program/excellon/text/header_words.h"
#include "program/model/setting_lengths.h"
#include <fmt/format.h>

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

}  // namespace

// --- tools -------------------------------------------------------------------------------------

void Interpreter::select_tool(const Block& block) {
  if (refuse_while_plunged(block)) return;
  const auto read =
      read_tool_block(block, {format(), &header_.tools, program_.reading.diameter_page}, reporter_);
  if (!read) return;
  has_dimension_ |= has_dimension(read->tool);
  if (const Word* const word = padded_length(block, format())) warn_padded(block, *word);
  const auto index = [this] { return compensation_index_.value_or(tool_ ? tool_->number : 0); };
  const int index_before = index();
  tool_ = known_tool(block, *read);
  compensation_index_ = read->compensation_index;
  if (modal_.motion != Motion::Drill && index() != index_before) {
    late_index_.emplace(Place{reporter_.file(), block.line, block.column}, block.text);
  }
  emitter_.take(block.line, {*tool_, read->compensation_index});
}

/// Everything that is known of the tool of a block: what the block and earlier blocks say, and the
/// header, which rules, unless OM48 or, for rates, G07 says otherwise.
/// Source CNC-7 manual, Keyboard and Header Commands vs. Body Commands
Tool Interpreter::known_tool(const Block& block, const ToolBlock& read) {
  const int number = read.tool.number;
  const auto defined = header_.tools.find(number);
  const bool is_defined = defined != header_.tools.end();
  const bool is_bare = read.tool == Tool{.number = number};
  if (number > 0 && !is_defined && is_bare && !header_.tools.empty() &&
      undefined_tools_.insert(number).second) {
    report(Code::ToolUndefined, block, block.words[0], "a tool that the header defines");
  }
  const bool is_limited = is_defined && defined->second.max_hits.has_value();
  Tool& body = body_tools_[number];
  const bool sets_hits = read.tool.max_hits.has_value() || read.turns_hits_off;
  if (sets_hits) body_hits_off_[number] = read.turns_hits_off && (body_rules_ || !is_limited);
  if (read.turns_hits_off) body.max_hits.reset();
  Tool said = read.tool;
  const Tool header = is_defined ? defined->second : Tool{.number = number};
  if (!body_rules_) {
    const bool contradicts = leave_to(header, body_rates_, said);
    if (contradicts || (read.turns_hits_off && is_limited)) {
      report(Code::ToolDataIgnored, block, block.words[0], "the header's data, which are used");
    }
  }
  fill_missing(said, body);
  body = said;
  fill_missing(said, header);
  if (body_hits_off_[number]) said.max_hits.reset();
  return said;
}

/// F# or B# in a block of its own: the table's feed in rout mode, else the tool's.
void Interpreter::rate(const Block& block) {
  const Word& word = block.words[0];
  if (!is_alone(block)) return;
  const bool is_table = word.letter == 'F' && modal_.motion != Motion::Drill;
  std::optional<Feed> read;
  if (!read_rate(block, word, format(), is_table, reporter_, read)) return;
  has_dimension_ = true;
  if (is_table) {
    set_table_feed(block, read);
    return;
  }
  if (!tool_ || tool_->number == 0) {
    return report(Code::ToolMissing, block, word, "T# before it: the rate is the tool's");
  }
  const auto defined = header_.tools.find(tool_->number);
  const bool body_wins = body_rules_ || body_rates_ || defined == header_.tools.end() ||
                         !(word.letter == 'F' ? defined->second.infeed : defined->second.retract);
  if (!body_wins) {
    return report(Code::ToolDataIgnored, block, word, "the header's data, which are used");
  }
  (word.letter == 'F' ? tool_->infeed : tool_->retract) = read;
  Tool& known = body_tools_[tool_->number];
  (word.letter == 'F' ? known.infeed : known.retract) = read;
  ToolRate rate{.tool = tool_->number, .infeed = std::nullopt, .retract = std::nullopt};
  (word.letter == 'F' ? rate.infeed : rate.retract) = read;
  emitter_.put(block.line, rate);
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
  const auto zero_set = displacement_mm<frame::Machine>(axes_(set).in_mm());
  const auto correction = header_.zero_correction;
  place_.work_zero = options_.absolute_zero +
                     displacement_mm<frame::Machine>(correction ? axes_(*correction).in_mm()
                                                                : options_.work_zero.in_mm()) +
                     zero_set;
  for (AxisUser& user : modal_.user) {
    if (user != AxisUser::None) user = AxisUser::Lost;
  }
  emitter_.put(block.line, ZeroSet{zero_set, place_.work_zero});
}

/// M71, M72.
void Interpreter::set_unit(const Block& block, LengthUnit unit) {
  PartialFormat statement;
  statement.unit = unit;
  statement.from = std::string(block.text);
  check_obeyed(stated_, statement, block.text, block.line, block.column, reporter_);
  if (stated_.is_contradicted_by(statement, StatedFormat::Form::Code)) {
    return report_contradiction(block);
  }
  if (stated_.states_unit() && unit == format().unit) return;
  StatedFormat stated = stated_;
  stated.add(StatedFormat::Source::Word, statement);
  take_format(block, std::move(stated));
}

void Interpreter::report_contradiction(const Block& block) {
  reporter_.report(Code::ArgumentInvalid,
                   block.line,
                   block.column,
                   quoted(block.text) + " contradicts " + format().summary(),
                   "one number format for the whole program");
}

/// A format only before anything moved, since it changes what numbers mean. Numbers that came
/// before the first statement of a unit were read in the manual's default.
/// Source CNC-7 manual, Part Program Headers: "must be specified before any commands with
/// dimensions"
void Interpreter::take_format(const Block& block, StatedFormat stated) {
  const NumberFormat& next = stated.format();
  if (next != format() && (has_motion_ || in_pattern_)) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  "the unit before the first coordinate and outside step and repeat");
  }
  if (is_late_unit(next.unit)) {
    reporter_.report(Code::ArgumentInvalid,
                     block.line,
                     block.column,
                     quoted(block.text) + " comes behind numbers whose unit it states",
                     std::string(kFormatFirst));
  }
  stated_ = std::move(stated);
  plain_ = PlainReader(format());
}

bool Interpreter::is_late_unit(LengthUnit unit) const {
  return !stated_.states_unit() && has_dimension_ && unit != format().unit;
}

/// A comment that states another format than the one in force: two files may have been joined.
/// Digits that METRIC states rule over comments. One that states the same counts from here on.
void Interpreter::check_comment(const SourceLine& line) {
  using Source = StatedFormat::Source;
  const CommentFormat comment = read_comment_format(line.text);
  if (comment.is_incremental) steps_comment_ = {line, *comment.is_incremental};
  const PartialFormat statement{
      comment.unit, comment.zeros, comment.digits, std::string(line.text)};
  if (statement.is_empty()) return;
  check_obeyed(stated_, statement, line.text, line.number, line.column, reporter_);
  const PartialFormat parts = stated_.obeyed(Source::Comment, statement);
  const NumberFormat& now = format();
  const bool has_digits_of_word = stated_.source_of_digits() == Source::Word;
  const bool is_other_digits = parts.digits && !has_digits_of_word &&
                               *parts.digits != std::pair(now.integer_digits, now.decimal_digits);
  const bool is_other_unit = parts.unit && *parts.unit != now.unit;
  const bool is_other_zeros = parts.zeros && *parts.zeros != now.zeros;
  if (is_other_unit || is_other_zeros || is_other_digits) {
    const bool is_left_open = (is_other_unit && !stated_.states_unit()) ||
                              (is_other_zeros && !stated_.states_zeros()) ||
                              (is_other_digits && !stated_.states_digits());
    return refuse_comment(line, parts, is_left_open);
  }
  if (has_motion_) return;
  stated_.add_comment_of_body(statement);
  plain_ = PlainReader(format());  // digits are stated now
}

/// What the program leaves open was taken from outside of it (nc_param.txt, the control's last
/// setting), or is the manual's, before this comment came: the operator decides.
void Interpreter::refuse_comment(const SourceLine& line,
                                 const PartialFormat& parts,
                                 bool is_left_open) {
  const NumberFormat& now = format();
  std::string what = quoted(line.text) + " contradicts " + now.summary();
  std::string expected = "one number format for the whole program";
  if (is_left_open) {
    NumberFormat other = now;
    other.unit = parts.unit.value_or(now.unit);
    other.zeros = parts.zeros.value_or(now.zeros);
    if (other.unit != now.unit) other.take_usual_digits();
    if (parts.digits) std::tie(other.integer_digits, other.decimal_digits) = *parts.digits;
    const std::string evidence = stated_.evidence();
    if (!evidence.empty()) what += " (" + evidence + ")";
    expected = fmt::format(
        "--format {}, as the comment has it, or --format {}", other.option(), now.option());
  }
  reporter_.report(
      Code::ArgumentInvalid, line.number, line.column, std::move(what), std::move(expected));
}

/// Whether coordinates are steps a control knows by G90, G91 and ICI alone. A comment that says
/// otherwise than the mode in force is no order: one of the two is wrong.
bool Interpreter::agrees_with_comment(const Block& block) {
  const auto [line, is_incremental] = *std::exchange(steps_comment_, std::nullopt);
  if (is_incremental == modal_.incremental) return true;
  const auto kind = [](bool is_step) { return is_step ? "incremental (G91)" : "absolute (G90)"; };
  reporter_.report(Code::ArgumentInvalid,
                   line.number,
                   line.column,
                   fmt::format("{} states {} coordinates, and {} of line {} is read as {}",
                               quoted(line.text),
                               kind(is_incremental),
                               quoted(block.text),
                               block.line,
                               kind(modal_.incremental)),
                   "G91 or G90 between them, as the coordinates are meant");
  return false;
}

/// A header command in the body: "there is no harm done" if the header says the same, and what it
/// says otherwise is not used. What changes places holds only before the first one.
/// Source CNC-7 manual, Duplicate Commands; Keyboard and Header Commands vs. Body Commands
void Interpreter::header_word(const SourceLine& line) {
  Block block;
  block.line = line.number;
  block.column = line.column;
  block.text = line.text;
  if (refuse_pending(block.line, block.text)) return;
  const HeaderCommand command = split_header_command(block.text);
  const auto& [word, value] = command;
  if (word == "INCH" || word == "METRIC") return unit_word(block, command);
  const OptionAgain again = compare_with_header(block, command);
  if (again == OptionAgain::Contradicts) return;
  if (again == OptionAgain::Same) {
    if (word != "ICI") return;
    steps_comment_.reset();
    if (modal_.incremental == header_.incremental) return;
    return reporter_.report(Code::ArgumentInvalid,
                            block.line,
                            block.column,
                            quoted(block.text) + " behind " + (modal_.incremental ? "G91" : "G90"),
                            "G90 and G91 alone, or ICI in the header alone");
  }
  const bool is_known_value =
      word == "ICI" ? value.empty() || value == "ON" || value == "OFF"
                    : kind_of_header_word(word) == HeaderWordKind::Passed && value != "T";
  if (!is_known_value || in_pattern_ || in_stored_pattern_ || is_plunged_) {
    return report_outside(Code::CommandMisplaced, block);
  }
  report_outside(Code::HeaderWordInBody, block);
  if (word != "ICI") return pass_on_setting(block);
  modal_.incremental = value != "OFF";
  steps_comment_.reset();
}

/// An option that the header has as well; More: it has none. Contradictions are reported.
OptionAgain Interpreter::compare_with_header(const Block& block, const HeaderCommand& command) {
  const auto known = header_.options.find(command.word);
  if (known == header_.options.end()) return OptionAgain::More;
  const HeaderCommand first{known->first, known->second};
  const OptionAgain again = compare_options(first, command, stated_);
  if (again == OptionAgain::Contradicts) {
    reporter_.report(Code::ArgumentInvalid,
                     block.line,
                     block.column,
                     quoted(block.text) + " behind " + quoted(first.text()),
                     "one option, in the header");
  }
  return again;
}

void Interpreter::report_outside(Code code, const Block& block) {
  reporter_.report(code, block.line, block.column, quoted(block.text), "it between M48 and %");
}

/// INCH or METRIC, perhaps with zeros; digits are the header's alone.
void Interpreter::unit_word(Block& block, const HeaderCommand& command) {
  std::optional<PartialFormat> statement = unit_statement(command);
  if (!statement) return report_outside(Code::CommandMisplaced, block);
  check_obeyed(stated_, *statement, block.text, block.line, block.column, reporter_);
  const PartialFormat parts = stated_.obeyed(StatedFormat::Source::Word, *statement);
  if (parts.is_empty()) return;
  const OptionAgain again = compare_with_header(block, command);
  if (again == OptionAgain::Contradicts) return;
  if (stated_.is_contradicted_by(*statement, StatedFormat::Form::Word)) {
    return report_contradiction(block);
  }
  const bool says_nothing_new =
      stated_.states_unit() && !parts.digits && (!parts.zeros || stated_.states_zeros());
  if (again == OptionAgain::Same || says_nothing_new) return;
  if (parts.digits || in_pattern_ || in_stored_pattern_ || is_plunged_ || has_motion_) {
    return report_outside(Code::CommandMisplaced, block);
  }
  statement->from = std::string(block.text);
  StatedFormat stated = stated_;
  stated.add(StatedFormat::Source::Word, *statement);
  const NumberFormat& next = stated.format();
  const bool is_late = is_late_unit(next.unit);  // take_format() says so
  if (has_dimension_ && next.zeros != format().zeros && !is_late) {
    reporter_.report(Code::ArgumentInvalid,
                     block.line,
                     block.column,
                     quoted(block.text) + " comes behind numbers whose zeros it states",
                     std::string(kFormatFirst));
  } else if (!is_late) {
    report_outside(Code::HeaderWordInBody, block);
  }
  block.words[0] = {command.word.front(), block.column, command.word.substr(1)};
  block.n_words = 1;
  take_format(block, std::move(stated));
}

/// Settings are passed on as written, and outputs state one unit for all of them.
void Interpreter::pass_on_setting(const Block& block) {
  const NumberFormat written = header_.number_format();
  has_dimension_ |= has_length(block.text);
  if ((has_length(block.text) && format().unit != written.unit) ||
      (has_bare_length(block.text) && format().zeros != written.zeros)) {
    return reporter_.report(
        Code::NotSupported,
        block.line,
        block.column,
        quoted(block.text) + " is not in the number format of the header, " + written.summary(),
        "one unit, stated in the header");
  }
  pass_on(block.line, block.text);
}

}  // namespace panelcal::excellon
