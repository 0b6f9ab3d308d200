// SPDX-License-Identifier: Apache-2.0
// Tools and their data, zeros and units.
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "program/excellon/interpreter/parts.h"
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

/// Everything that is known of the tool of a block: what the block and earlier blocks say, and the
/// header, which rules, unless OM48 or, for rates, G07 says otherwise.
/// Source CNC-7 manual, Keyboard and Header Commands vs. Body Commands
Tool known_tool(Walk& walk, const Block& block, const ToolBlock& read) {
  const int number = read.tool.number;
  const auto defined = walk.header.tools.find(number);
  const bool is_defined = defined != walk.header.tools.end();
  const bool is_bare = read.tool == Tool{.number = number};
  if (number > 0 && !is_defined && is_bare && !walk.header.tools.empty() &&
      walk.undefined_tools.insert(number).second) {
    walk.reporter.report(Code::ToolUndefined, block.first(), "a tool that the header defines");
  }
  const bool is_limited = is_defined && defined->second.max_hits.has_value();
  Tool& body = walk.body_tools[number];
  const bool sets_hits = read.tool.max_hits.has_value() || read.turns_hits_off;
  if (sets_hits)
    walk.body_hits_off[number] = read.turns_hits_off && (walk.body_rules || !is_limited);
  if (read.turns_hits_off) body.max_hits.reset();
  Tool said = read.tool;
  const Tool header = is_defined ? defined->second : Tool{.number = number};
  if (!walk.body_rules) {
    const bool contradicts = leave_to(header, walk.body_rates, said);
    if (contradicts || (read.turns_hits_off && is_limited)) {
      walk.reporter.report(
          Code::ToolDataIgnored, block.first(), "the header's data, which are used");
    }
  }
  fill_missing(said, body);
  body = said;
  fill_missing(said, header);
  if (walk.body_hits_off[number]) said.max_hits.reset();
  return said;
}

void report_contradiction(Walk& walk, const Block& block) {
  walk.reporter.report(Code::ArgumentInvalid,
                       block,
                       " contradicts " + walk.format().summary(),
                       "one number format for the whole program");
}

bool is_late_unit(const Walk& walk, LengthUnit unit) {
  return !walk.stated.states_unit() && walk.has_dimension && unit != walk.format().unit;
}

/// A format only before anything moved, since it changes what numbers mean. Numbers that came
/// before the first statement of a unit were read in the manual's default.
/// Source CNC-7 manual, Part Program Headers: "must be specified before any commands with
/// dimensions"
void take_format(Walk& walk, const Block& block, StatedFormat stated) {
  const NumberFormat& next = stated.format();
  if (next != walk.format() && (walk.has_motion || walk.in_pattern)) {
    return walk.reporter.report(Code::CommandMisplaced,
                                block.first(),
                                "the unit before the first coordinate and outside step and repeat");
  }
  if (is_late_unit(walk, next.unit)) {
    walk.reporter.report(Code::ArgumentInvalid,
                         block,
                         " comes behind numbers whose unit it states",
                         std::string(kFormatFirst));
  }
  walk.stated = std::move(stated);
  walk.plain = PlainReader(walk.format());
}

/// What the program leaves open was taken from outside of it (nc_param.txt, the control's last
/// setting), or is the manual's, before this comment came: the operator decides.
void refuse_comment(Walk& walk,
                    const SourceLine& line,
                    const PartialFormat& parts,
                    bool is_left_open) {
  const NumberFormat& now = walk.format();
  std::string what = quoted(line.text) + " contradicts " + now.summary();
  std::string expected = "one number format for the whole program";
  if (is_left_open) {
    NumberFormat other = now;
    other.unit = parts.unit.value_or(now.unit);
    other.zeros = parts.zeros.value_or(now.zeros);
    if (other.unit != now.unit) other.take_usual_digits();
    if (parts.digits) std::tie(other.integer_digits, other.decimal_digits) = *parts.digits;
    const std::string evidence = walk.stated.evidence();
    if (!evidence.empty()) what += " (" + evidence + ")";
    expected = fmt::format(
        "--format {}, as the comment has it, or --format {}", other.option(), now.option());
  }
  walk.reporter.report(
      Code::ArgumentInvalid, line.number, line.column, std::move(what), std::move(expected));
}

/// An option that the header has as well; More: it has none. Contradictions are reported.
OptionAgain compare_with_header(Walk& walk, const Block& block, const HeaderCommand& command) {
  const auto known = walk.header.options.find(command.word);
  if (known == walk.header.options.end()) return OptionAgain::More;
  const HeaderCommand first{known->first, known->second};
  const OptionAgain again = compare_options(first, command, walk.stated);
  if (again == OptionAgain::Contradicts) {
    walk.reporter.report(Code::ArgumentInvalid,
                         block,
                         " behind " + quoted(first.text()),
                         "one option, in the header");
  }
  return again;
}

void report_outside(Walk& walk, Code code, const Block& block) {
  walk.reporter.report(code, block, "it between M48 and %");
}

/// INCH or METRIC, perhaps with zeros; digits are the header's alone.
void unit_word(Walk& walk, Block& block, const HeaderCommand& command) {
  std::optional<PartialFormat> statement = unit_statement(command);
  if (!statement) return report_outside(walk, Code::CommandMisplaced, block);
  check_obeyed(walk.stated, *statement, block.text, block.line, block.column, walk.reporter);
  const PartialFormat parts = walk.stated.obeyed(StatedFormat::Source::Word, *statement);
  if (parts.is_empty()) return;
  const OptionAgain again = compare_with_header(walk, block, command);
  if (again == OptionAgain::Contradicts) return;
  if (walk.stated.is_contradicted_by(*statement, StatedFormat::Form::Word)) {
    return report_contradiction(walk, block);
  }
  const bool says_nothing_new =
      walk.stated.states_unit() && !parts.digits && (!parts.zeros || walk.stated.states_zeros());
  if (again == OptionAgain::Same || says_nothing_new) return;
  if (parts.digits || walk.is_in_copies() || walk.is_plunged || walk.has_motion) {
    return report_outside(walk, Code::CommandMisplaced, block);
  }
  statement->from = std::string(block.text);
  StatedFormat stated = walk.stated;
  stated.add(StatedFormat::Source::Word, *statement);
  const NumberFormat& next = stated.format();
  const bool is_late = is_late_unit(walk, next.unit);  // take_format() says so
  if (walk.has_dimension && next.zeros != walk.format().zeros && !is_late) {
    walk.reporter.report(Code::ArgumentInvalid,
                         block,
                         " comes behind numbers whose zeros it states",
                         std::string(kFormatFirst));
  } else if (!is_late) {
    report_outside(walk, Code::HeaderWordInBody, block);
  }
  block.words[0] = {command.word.front(), block.column, command.word.substr(1)};
  block.n_words = 1;
  take_format(walk, block, std::move(stated));
}

/// Settings are passed on as written, and outputs state one unit for all of them.
void pass_on_setting(Walk& walk, const Block& block) {
  const NumberFormat written = walk.header.number_format();
  walk.has_dimension |= has_length(block.text);
  if ((has_length(block.text) && walk.format().unit != written.unit) ||
      (has_bare_length(block.text) && walk.format().zeros != written.zeros)) {
    return walk.reporter.report(Code::NotSupported,
                                block,
                                " is not in the number format of the header, " + written.summary(),
                                "one unit, stated in the header");
  }
  walk.pass_on(block.line, block.text);
}

}  // namespace

// --- tools -------------------------------------------------------------------------------------

void select_tool(Walk& walk, const Block& block) {
  if (refuse_while_plunged(walk, block)) return;
  const auto read =
      read_tool_block(block,
                      {walk.format(), &walk.header.tools, walk.program.reading.diameter_page},
                      walk.reporter);
  if (!read) return;
  walk.has_dimension |= has_dimension(read->tool);
  if (const Word* const word = padded_length(block, walk.format())) warn_padded(walk, block, *word);
  const auto index = [&walk] {
    return walk.compensation_index.value_or(walk.tool ? walk.tool->number : 0);
  };
  const int index_before = index();
  walk.tool = known_tool(walk, block, *read);
  walk.compensation_index = read->compensation_index;
  if (walk.modal.motion != Motion::Drill && index() != index_before) {
    walk.late_index.emplace(Place{walk.reporter.file(), block.line, block.column}, block.text);
  }
  walk.emitter.take(block.line, {*walk.tool, read->compensation_index});
}

/// F# or B# in a block of its own: the table's feed in rout mode, else the tool's.
void rate(Walk& walk, const Block& block) {
  const Word& word = block.words[0];
  if (!is_alone(walk, block)) return;
  const bool is_table = word.letter == 'F' && walk.modal.motion != Motion::Drill;
  std::optional<Feed> read;
  if (!read_rate(block, word, walk.format(), is_table, walk.reporter, read)) return;
  walk.has_dimension = true;
  if (is_table) {
    set_table_feed(walk, block, read);
    return;
  }
  if (!walk.tool || walk.tool->number == 0) {
    return walk.reporter.report(
        Code::ToolMissing, block.in(word), "T# before it: the rate is the tool's");
  }
  const auto defined = walk.header.tools.find(walk.tool->number);
  const bool body_wins = walk.body_rules || walk.body_rates || defined == walk.header.tools.end() ||
                         !(word.letter == 'F' ? defined->second.infeed : defined->second.retract);
  if (!body_wins) {
    return walk.reporter.report(
        Code::ToolDataIgnored, block.in(word), "the header's data, which are used");
  }
  (word.letter == 'F' ? walk.tool->infeed : walk.tool->retract) = read;
  Tool& known = walk.body_tools[walk.tool->number];
  (word.letter == 'F' ? known.infeed : known.retract) = read;
  ToolRate rate{.tool = walk.tool->number, .infeed = std::nullopt, .retract = std::nullopt};
  (word.letter == 'F' ? rate.infeed : rate.retract) = read;
  walk.emitter.put(block.line, rate);
}

// --- zero, units -------------------------------------------------------------------------------

void set_zero(Walk& walk, const Block& block) {
  MotionWords words;
  if (!read_words(walk, block, block.all().subspan(1), "XY", words)) return;
  if (!words.xy_mm[0] || !words.xy_mm[1]) {
    return walk.reporter.report(Code::CoordinateMissing, block.first(), "G93X#Y#");
  }
  if (walk.is_in_copies()) {
    return walk.reporter.report(
        Code::CommandMisplaced, block.first(), "G93 outside step and repeat and stored patterns");
  }
  if (!walk.vision.is_unused()) {
    return walk.reporter.report(
        Code::ZeroSetUnderCorrection, block.first(), "G93 before the first target");
  }
  const auto set = displacement_mm<frame::Programmed>(*words.xy_mm[0], *words.xy_mm[1]);
  const auto zero_set = displacement_mm<frame::Machine>(walk.axes(set).in_mm());
  const auto correction = walk.header.zero_correction;
  walk.place.work_zero =
      walk.options.absolute_zero +
      displacement_mm<frame::Machine>(correction ? walk.axes(*correction).in_mm()
                                                 : walk.options.work_zero.in_mm()) +
      zero_set;
  for (AxisUser& user : walk.modal.user) {
    if (user != AxisUser::None) user = AxisUser::Lost;
  }
  walk.emitter.put(block.line, ZeroSet{zero_set, walk.place.work_zero});
}

/// M71, M72.
void set_unit(Walk& walk, const Block& block, LengthUnit unit) {
  PartialFormat statement;
  statement.unit = unit;
  statement.from = std::string(block.text);
  check_obeyed(walk.stated, statement, block.text, block.line, block.column, walk.reporter);
  if (walk.stated.is_contradicted_by(statement, StatedFormat::Form::Code)) {
    return report_contradiction(walk, block);
  }
  if (walk.stated.states_unit() && unit == walk.format().unit) return;
  StatedFormat stated = walk.stated;
  stated.add(StatedFormat::Source::Word, statement);
  take_format(walk, block, std::move(stated));
}

/// A comment that states another format than the one in force: two files may have been joined.
/// Digits that METRIC states rule over comments. One that states the same counts from here on.
void check_comment(Walk& walk, const SourceLine& line) {
  using Source = StatedFormat::Source;
  const CommentFormat comment = read_comment_format(line.text);
  if (comment.is_incremental) walk.steps_comment = {line, *comment.is_incremental};
  const PartialFormat statement{
      comment.unit, comment.zeros, comment.digits, std::string(line.text)};
  if (statement.is_empty()) return;
  check_obeyed(walk.stated, statement, line.text, line.number, line.column, walk.reporter);
  const PartialFormat parts = walk.stated.obeyed(Source::Comment, statement);
  const NumberFormat& now = walk.format();
  const bool has_digits_of_word = walk.stated.source_of_digits() == Source::Word;
  const bool is_other_digits = parts.digits && !has_digits_of_word &&
                               *parts.digits != std::pair(now.integer_digits, now.decimal_digits);
  const bool is_other_unit = parts.unit && *parts.unit != now.unit;
  const bool is_other_zeros = parts.zeros && *parts.zeros != now.zeros;
  if (is_other_unit || is_other_zeros || is_other_digits) {
    const bool is_left_open = (is_other_unit && !walk.stated.states_unit()) ||
                              (is_other_zeros && !walk.stated.states_zeros()) ||
                              (is_other_digits && !walk.stated.states_digits());
    return refuse_comment(walk, line, parts, is_left_open);
  }
  if (walk.has_motion) return;
  walk.stated.add_comment_of_body(statement);
  walk.plain = PlainReader(walk.format());  // digits are stated now
}

/// Whether coordinates are steps a control knows by G90, G91 and ICI alone. A comment that says
/// otherwise than the mode in force is no order: one of the two is wrong.
bool agrees_with_comment(Walk& walk, const Block& block) {
  const auto [line, is_incremental] = *std::exchange(walk.steps_comment, std::nullopt);
  if (is_incremental == walk.modal.incremental) return true;
  const auto kind = [](bool is_step) { return is_step ? "incremental (G91)" : "absolute (G90)"; };
  walk.reporter.report(Code::ArgumentInvalid,
                       line,
                       fmt::format(" states {} coordinates, and {} of line {} is read as {}",
                                   kind(is_incremental),
                                   quoted(block.text),
                                   block.line,
                                   kind(walk.modal.incremental)),
                       "G91 or G90 between them, as the coordinates are meant");
  return false;
}

/// A header command in the body: "there is no harm done" if the header says the same, and what it
/// says otherwise is not used. What changes places holds only before the first one.
/// Source CNC-7 manual, Duplicate Commands; Keyboard and Header Commands vs. Body Commands
void header_word(Walk& walk, const SourceLine& line) {
  Block block;
  block.line = line.number;
  block.column = line.column;
  block.text = line.text;
  if (refuse_pending(walk, block.line, block.text)) return;
  const HeaderCommand command = split_header_command(block.text);
  const auto& [word, value] = command;
  if (word == "INCH" || word == "METRIC") return unit_word(walk, block, command);
  const OptionAgain again = compare_with_header(walk, block, command);
  if (again == OptionAgain::Contradicts) return;
  if (again == OptionAgain::Same) {
    if (word != "ICI") return;
    walk.steps_comment.reset();
    if (walk.modal.incremental == walk.header.incremental) return;
    return walk.reporter.report(Code::ArgumentInvalid,
                                block,
                                walk.modal.incremental ? " behind G91" : " behind G90",
                                "G90 and G91 alone, or ICI in the header alone");
  }
  const bool is_known_value =
      word == "ICI" ? value.empty() || value == "ON" || value == "OFF"
                    : kind_of_header_word(word) == HeaderWordKind::Passed && value != "T";
  if (!is_known_value || walk.is_in_copies() || walk.is_plunged) {
    return report_outside(walk, Code::CommandMisplaced, block);
  }
  report_outside(walk, Code::HeaderWordInBody, block);
  if (word != "ICI") return pass_on_setting(walk, block);
  walk.modal.incremental = value != "OFF";
  walk.steps_comment.reset();
}

}  // namespace panelcal::excellon
