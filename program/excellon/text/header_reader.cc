// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header_reader.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "program/excellon/text/body_start.h"
#include "program/excellon/text/digit_evidence.h"
#include "program/excellon/text/format_choice.h"
#include "program/excellon/text/header_format.h"
#include "program/excellon/text/lexer.h"
#include "program/excellon/text/number_census.h"
#include "program/excellon/text/spelling.h"
#include "program/excellon/text/tools.h"
#include "program/model/setting_lengths.h"
#include "program/text/gaps.h"
#include "program/walk/reporter.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

/// With a decimal point, which any reader takes alike whatever its zeros and digits.
std::string with_point(double value) {
  std::string text = fmt::format("{:.9g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

class HeaderReader {
 public:
  HeaderReader(const std::string& file,
               std::string_view bytes,
               const StatedFormat& outside,
               const ReadOptions& reading,
               DiagnosticLog& log)
      : cursor_(bytes),
        reporter_(file, log),
        reading_(reading),
        format_(header_, outside, reporter_) {}

  Header read() {
    while (true) {
      const HeaderAhead ahead = look_ahead(cursor_, !has_read_);
      if (ahead == HeaderAhead::None) break;
      read_up_to(ahead);
      has_read_ = true;
      if (ahead == HeaderAhead::Start) read_between_marks();
    }
    find_body();
    format_.check_comments();
    return std::move(header_);
  }

 private:
  /// Reads lines up to M48, or up to a header command outside the header.
  void read_up_to(HeaderAhead ahead) {
    while (true) {
      const SourceLine line = cursor_.next();
      const std::string_view text = trimmed(line.text);
      if (text.empty() || text == "%") continue;
      if (text.front() == ';') {
        format_.read_comment(line.number, text);
        continue;
      }
      if (text == "M48") {
        if (std::exchange(start_line_, line.number) != 0) warn_outside(line, text);
        return;
      }
      const bool is_word = is_header_word(text);
      if (!is_word || !is_stated(line, text)) {
        if (!is_set_up(text)) warn_outside(line, text);
        read_line(line, text);
      }
      if (is_word && ahead == HeaderAhead::Word) return;
    }
  }

  void warn_outside(const SourceLine& line, std::string_view text) {
    reporter_.report(Code::HeaderWordInBody,
                     line.number,
                     column_of(line, text),
                     quoted(text),
                     text == "M48" ? "one header" : "it between M48 and %");
  }

  /// An option that the header has as well changes nothing; another one would not be used.
  /// False: it is to be read.
  bool is_stated(const SourceLine& line, std::string_view text) {
    const HeaderCommand command = split_header_command(text);
    const auto known = header_.options.find(command.word);
    if (known == header_.options.end()) return false;
    const HeaderCommand first{known->first, known->second};
    if (const auto statement = unit_statement(command)) {
      check_obeyed(header_.stated, *statement, text, line.number, column_of(line, text), reporter_);
    }
    const OptionAgain again = compare_options(first, command, header_.stated);
    if (again == OptionAgain::More) return false;
    if (again == OptionAgain::Same) return true;
    invalid(line.number,
            column_of(line, text),
            quoted(text) + " behind " + quoted(first.text()),
            "one option, in the header");
    return true;
  }

  static int column_of(const SourceLine& line, std::string_view text) {
    return static_cast<int>(text.data() - line.text.data()) + line.column;
  }

  void read_between_marks() {
    while (!cursor_.at_end()) {
      const SourceLine line = cursor_.next();
      const std::string_view text = trimmed(line.text);
      if (text == "%" || text == "M95") {
        header_.end_line = line.number;
        header_.stops_at_end = text == "%";
        return;
      }
      read_line(line, text);
    }
    reporter_.report(Code::HeaderUnclosed, start_line_, "", "% or M95");
  }

  /// Without a header the body begins at the first block, or behind a rewind stop; comments before
  /// it count.
  void find_body() {
    header_.body = cursor_.place();
    bool may_rewind = true;
    while (!has_read_ && !cursor_.at_end()) {
      if (may_rewind) header_.body = cursor_.place();
      const SourceLine line = cursor_.next();
      const std::string_view text = trimmed(line.text);
      if (text.empty()) continue;
      if (text.front() == ';') {
        format_.read_comment(line.number, text);
        continue;
      }
      if (text != "%" || !std::exchange(may_rewind, false)) return;
      header_.body = cursor_.place();
    }
  }

  void read_line(const SourceLine& line, std::string_view text) {
    if (text.empty()) return;
    const int column = column_of(line, text);
    if (text.front() == ';') return format_.read_comment(line.number, text);
    if (text.front() == 'T' && text.size() > 1 && text[1] >= '0' && text[1] <= '9') {
      return read_tool(line);
    }
    if (text.front() == '/' && text.size() > 1) return read_slashed(line, column, text);
    // A lone / clears the links; a depth offset without a tool is the machine's mean.
    if (is_tool_link(text) || text == "/" || is_depth_offset(text)) {
      return pass_on(line.number, text);
    }
    if (text == "G90" || text == "G91") {
      header_.incremental = text == "G91";
      header_.states_incremental = true;
      return;
    }
    if (text == "M71" || text == "M72") {
      const std::string_view word = text == "M71" ? "METRIC" : "INCH";
      return format_.read_unit(line.number, column, text, {word, {}});
    }
    const bool is_spaced = text.find_first_of(" \t") != std::string_view::npos;
    if (is_spaced && text.find(';') == std::string_view::npos && is_header_word(text)) {
      return read_spaced(line.number, column, text);
    }
    const HeaderCommand command = split_header_command(text);
    read_word(line.number, column, text, command.word, command.value);
  }

  /// `METRIC, TZ`.
  void read_spaced(int line, int column, std::string_view text) {
    std::string squeezed(text);
    std::erase_if(squeezed, is_gap);
    reporter_.report(Code::NotationAccepted,
                     line,
                     column,
                     quoted(text) + " is read as " + quoted(squeezed),
                     "no blanks in a header command");
    const HeaderCommand command = split_header_command(squeezed);
    read_word(line, column, squeezed, command.word, command.value);
  }

  /// Block delete, in the header only by the header's own switch.
  void read_slashed(const SourceLine& line, int column, std::string_view text) {
    if (!header_.block_delete) {
      reporter_.report(Code::CommandMisplaced,
                       line.number,
                       column,
                       quoted(text) + " may be left out or not",
                       "BLKD,ON or BLKD,OFF before it");
    } else if (!*header_.block_delete) {
      const SourceLine rest = without_slash(line);
      read_line(rest, trimmed(rest.text));
    }
  }

  void read_word(
      int line, int column, std::string_view text, std::string_view word, std::string_view value) {
    const auto kind = kind_of_header_word(word);
    if (!kind) return report_unknown(line, column, word);
    // Resets and rows of tables are no options.
    if (word != "R" && word != "CP") header_.options.insert_or_assign(std::string(word), value);
    const int value_column = column + static_cast<int>(word.size()) + 1;
    switch (*kind) {
      case HeaderWordKind::Passed:
        return pass_on(line, text);
      case HeaderWordKind::Refused:
        reporter_.report(Code::NotSupported,
                         line,
                         column,
                         quoted(text) + " may move a zero in a way that the manual does not state",
                         "the zero set at the machine, or G93X#Y#");
        return;
      case HeaderWordKind::Handled:
        break;
    }
    if (word == "INCH" || word == "METRIC") {
      return format_.read_unit(line, column, text, {word, value});
    }
    if (word == "ICI") {
      header_.states_incremental = true;
      return read_switch(line, value_column, value, header_.incremental);
    }
    if (word == "OM48") return read_switch(line, value_column, value, header_.body_rules);
    if (word == "BLKD") {
      header_.block_delete.emplace();
      return read_switch(line, value_column, value, *header_.block_delete);
    }
    if (word == "Z" || word == "ZC") {
      return read_zero(
          line, value_column, value, word == "Z" ? header_.zero_set : header_.zero_correction);
    }
    if (word == "CAN_TEXT_OFF") {
      Eigen::Vector2d offset_mm = header_.text_offset.in_mm();
      const auto done = read_text_offset(value, header_.format(), offset_mm);
      if (!done) return invalid(line, value_column, quoted(value), done.error());
      header_.text_offset = displacement_mm<frame::Programmed>(offset_mm);
      return note_dimension(value);
    }
    if (word == "CP") return read_compensation(line, value_column, value);
    pass_on(line, text);
    if (word == "CCW") return read_direction(line, column, value_column, value);
    if (value.size() == 1 && value[0] >= '1' && value[0] <= (word == "VER" ? '8' : '2')) {
      if (word == "VER") {
        header_.axis_version = value[0] - '0';
      } else {
        header_.set = value == "1" ? ProgramSet::FormatOne : ProgramSet::FormatTwo;
      }
      return;
    }
    invalid(
        line, value_column, quoted(value), word == "VER" ? "VER,1 to VER,8" : "FMAT,1 or FMAT,2");
  }

  /// `X#Y#`, both axes.
  void read_zero(int line,
                 int column,
                 std::string_view value,
                 std::optional<Displacement<frame::Programmed>>& out) {
    Block block;
    Eigen::Vector2d zero_mm;
    const bool is_point = !lex({value, line, column}, block) && block.n_words == 2 &&
                          block.words[0].letter == 'X' && block.words[1].letter == 'Y' &&
                          block.argument_column == 0;
    for (int axis = 0; axis < 2 && is_point; ++axis) {
      const Word& word = block.words[static_cast<std::size_t>(axis)];
      const ParsedLength parsed = parse_length(word.number, header_.format());
      if (parsed.fault != NumberFault::None) {
        return reporter_.report_number(
            parsed.fault, word.number, line, word.column + 1, header_.format());
      }
      zero_mm[axis] = parsed.value.in_mm();
    }
    if (!is_point) return invalid(line, column, quoted(value), "X#Y#");
    out = displacement_mm<frame::Programmed>(zero_mm);
    note_dimension(value);
    if (&out != &header_.zero_correction) {  // the zero set is an operation of its own
      header_.zero_line = line;
      return;
    }
    const Eigen::Vector2d written = zero_mm / header_.format().one_unit().in_mm();
    pass_on(line, fmt::format("ZC,X{}Y{}", with_point(written.x()), with_point(written.y())));
  }

  /// CP,index,diameter.
  void read_compensation(int line, int column, std::string_view value) {
    const auto comma = value.find(',');
    const auto index = parse_count(value.substr(0, comma));
    const ParsedLength diameter = comma == std::string_view::npos
                                      ? ParsedLength{{}, NumberFault::Malformed}
                                      : parse_length(value.substr(comma + 1), header_.format());
    if (!index || *index < 1 || *index > 99 || comma + 1 == value.size() ||
        diameter.fault != NumberFault::None) {
      return invalid(line, column, quoted(value), "CP,index,diameter with an index from 1 to 99");
    }
    header_.compensation_values[*index] = diameter.value;
    note_dimension(value.substr(comma + 1));
    // With a decimal point, since outputs may have other digits.
    const double written = diameter.value / header_.format().one_unit();
    pass_on(line, fmt::format("CP,{},{}", *index, with_point(written)));
  }

  void read_direction(int line, int column, int value_column, std::string_view value) {
    bool is_on = false;
    read_switch(line, value_column, value, is_on);
    if (!is_on) return;
    reporter_.report(Code::SettingUnseen,
                     line,
                     column,
                     "the control reverses the direction of routing; outputs keep it as programmed",
                     "CCW,OFF");
  }

  void report_unknown(int line, int column, std::string_view word) {
    const std::string_view near = nearest_header_word(word);
    reporter_.report(Code::HeaderWordUnknown,
                     line,
                     column,
                     quoted(word),
                     near.empty() ? "a command of the manual's header table"
                                  : "did you mean " + quoted(near) + "?");
  }

  void invalid(int line, int column, std::string what, std::string expected) {
    reporter_.report(Code::ArgumentInvalid, line, column, std::move(what), std::move(expected));
  }

  void read_tool(const SourceLine& line) {
    Block block;
    if (const auto fault = lex(line, block)) {
      reporter_.report_syntax(line.number, *fault);
      return;
    }
    const auto tool =
        read_tool_block(block, {header_.format(), nullptr, reading_.diameter_page}, reporter_);
    if (!tool) return;
    const Word* const padded = padded_length(block, header_.format());
    if (padded != nullptr && !std::exchange(warned_padded_, true)) {
      reporter_.report_padded(padded->text(), line.number, padded->column, header_.format());
    }
    header_.has_dimension |= has_dimension(tool->tool);
    header_.has_bare_dimension |= std::ranges::any_of(block.all(), [](const Word& word) {
      return (word.letter == 'C' || word.letter == 'Z') && is_bare(word.number);
    });
    header_.tool_lines.emplace(tool->tool.number, line.number);
    Tool merged = tool->tool;
    Tool& known = header_.tools.try_emplace(merged.number, merged).first->second;
    fill_missing(merged, known);
    const Tool latest = merged;
    fill_missing(known, merged);
    if (latest == known) return;
    invalid(line.number,
            block.column,
            quoted(block.text) + " defines the tool differently from before",
            "one definition of each tool");
  }

  void read_switch(int line, int column, std::string_view value, bool& state) {
    if (!value.empty() && value != "ON" && value != "OFF") {
      invalid(line, column, quoted(value), "ON or OFF");
    }
    state = value != "OFF";
  }

  void note_dimension(std::string_view numbers) {
    header_.has_dimension = true;
    header_.has_bare_dimension |= has_bare_number(numbers);
  }

  /// R,T resets the tool data that came so far.
  void pass_on(int line, std::string_view text) {
    if (has_length(text)) note_dimension(lengths_of(text));
    if (text == "R,T") {
      header_.tools.clear();
      header_.tool_lines.clear();
    }
    header_.settings.push_back({line, std::string(text)});
  }

  LineCursor cursor_;
  Reporter reporter_;
  const ReadOptions& reading_;
  Header header_;
  HeaderFormat format_;
  int start_line_ = 0;
  bool has_read_ = false;  ///< a header, or a command of it
  bool warned_padded_ = false;
};

/// Adds the units that the body states to those of the header. One that contradicts what stands
/// before it is refused where it is executed.
void add_body(const BodyStart& body, Header& header) {
  StatedFormat& whole = header.whole;
  whole = header.stated;
  for (const auto& [line, text, form, format] : body.units) {
    if (whole.is_contradicted_by(format, form)) return;
    const bool says_unit_again = whole.states_unit() && format.unit == whole.format().unit;
    const bool says_nothing_new = says_unit_again && (!format.zeros || whole.states_zeros());
    if (!says_nothing_new) whole.add(StatedFormat::Source::Word, format);
  }
}

}  // namespace

Header read_header(const SourceText& source,
                   const ReadOptions& reading,
                   DiagnosticLog& log,
                   const PatternTexts& read_patterns) {
  Spelling spelling = respell(source.bytes, Reporter(source.file, log));
  const std::string_view bytes =
      spelling.text.empty() ? source.bytes : std::string_view(spelling.text);
  StatedFormat outside(reading);
  const auto read = [&](DiagnosticLog& to) {
    return HeaderReader(source.file, bytes, outside, reading, to).read();
  };
  // Tool data may stand before the line that states the unit, or nothing does: the numbers say how
  // to read them, and the header is then read again.
  DiagnosticLog of_draft = log;
  Header header = read(of_draft);
  const BodyStart body = read_body_start(LineCursor(bytes, header.body), header.set);
  add_body(body, header);
  const PatternTexts patterns = spelling.calls_patterns ? read_patterns : PatternTexts();
  DiagnosticLog of_choice;
  const FormatChoice choice =
      choose_format({source.file, bytes, patterns, header, body, reading}, of_choice);
  if (!choice.numbers.is_empty()) {
    outside.add(StatedFormat::Source::Numbers, choice.numbers);
    of_draft = log;
    header = read(of_draft);
    add_body(body, header);
  }
  log = std::move(of_draft);
  for (const Diagnostic& diagnostic : of_choice.kept()) log.add(diagnostic);
  header.is_refused =
      choice.is_open || !check_digits(bytes, header, reading, Reporter(source.file, log));
  const bool uses_file = header.whole.uses(StatedFormat::Source::Beside);
  if (uses_file) header.format_file = reading.format_beside.file;
  header.calls_patterns = spelling.calls_patterns;
  header.respelled = std::move(spelling.text);
  return header;
}

}  // namespace panelcal::excellon
