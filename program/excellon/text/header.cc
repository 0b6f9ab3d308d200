// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "program/excellon/text/lexer.h"
#include "program/excellon/text/tools.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

enum class WordKind { Handled, Passed, Refused };

struct HeaderWord {
  std::string_view word;
  WordKind kind;
};

constexpr std::array kHeaderWords = {
#define EXCELLON_HEADER_WORD(word, command_class, effect, kind) HeaderWord{word, WordKind::kind},
#include "program/excellon/text/header_words.def"
};

std::string_view trim(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Digits before and behind a separator: `3:3`, `000.000` (there the zeros are counted).
std::optional<std::pair<int, int>> digit_pair(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto before = parse_count(text.substr(0, colon));
  const auto behind = parse_count(text.substr(colon + 1));
  if (!before || !behind || *before > 6 || *behind > 6 || *before + *behind == 0) {
    return std::nullopt;
  }
  return std::pair{*before, *behind};
}

bool is_digit_mask(std::string_view text) {
  const auto point = text.find('.');
  return point != std::string_view::npos && point >= 1 && point <= 6 &&
         text.size() - point - 1 >= 1 && text.size() - point - 1 <= 6 &&
         text.find_first_not_of("0.") == std::string_view::npos &&
         text.find('.', point + 1) == std::string_view::npos;
}

/// With a decimal point, which any reader takes alike whatever its zeros and digits.
std::string with_point(double value) {
  std::string text = fmt::format("{:.9g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

class HeaderReader {
 public:
  HeaderReader(const SourceText& source, const std::vector<Tool>& diameter_page, DiagnosticLog& log)
      : cursor_(source.bytes), reporter_(source.file, log), diameter_page_(diameter_page) {}

  Header read() {
    if (!find_start()) return std::move(header_);
    while (!cursor_.at_end()) {
      const SourceLine line = cursor_.next();
      const std::string_view text = trim(line.text);
      if (text == "%" || text == "M95") {
        header_.end_line = line.number;
        header_.stops_at_end = text == "%";
        return finish();
      }
      read_line(line, text);
    }
    reporter_.report(Code::HeaderUnclosed, start_line_, 1, "", "% or M95");
    return finish();
  }

 private:
  Header finish() {
    header_.body = cursor_.place();
    return std::move(header_);
  }

  /// Moves behind M48. Without one the body begins at the first line; a % there is a rewind stop,
  /// which some CAM systems also put before M48.
  bool find_start() {
    bool has_mark = false;
    while (!cursor_.at_end()) {
      if (!has_mark) header_.body = cursor_.place();
      const SourceLine line = cursor_.next();
      const std::string_view text = trim(line.text);
      if (text.empty()) continue;
      if (text.front() == ';') {
        read_comment(line.number, text);
        continue;
      }
      if (text == "%" && !has_mark) {
        has_mark = true;
        header_.body = cursor_.place();
        continue;
      }
      start_line_ = line.number;
      return text == "M48";
    }
    return false;
  }

  void read_line(const SourceLine& line, std::string_view text) {
    if (text.empty()) return;
    const int column = static_cast<int>(text.data() - line.text.data()) + 1;
    if (text.front() == ';') return read_comment(line.number, text);
    if (text.front() == 'T' && text.size() > 1 && text[1] >= '0' && text[1] <= '9') {
      return read_tool(line);
    }
    if (text.front() == '/' && text.size() > 1) return read_slashed(line, column, text);
    if (is_tool_link(text) || text == "/") {  // a lone / clears the links
      return pass_on(line.number, text);
    }
    // A depth offset without a tool is the machine's mean.
    if (text.size() > 1 && text[0] == 'Z' &&
        std::string_view("+-.0123456789").find(text[1]) != std::string_view::npos) {
      return pass_on(line.number, text);
    }
    // CAM systems write some of the body's modes into the header.
    if (text == "G90" || text == "G91") {
      header_.incremental = text == "G91";
      return;
    }
    if (text == "M71" || text == "M72") {
      return read_unit(line.number, column, text == "M71" ? "METRIC" : "INCH", {});
    }
    const auto comma = text.find(',');
    const std::string_view word = text.substr(0, comma);
    const std::string_view value =
        comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    read_word(line.number, column, text, word, value);
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
      read_line(rest, trim(rest.text));
    }
  }

  void read_word(
      int line, int column, std::string_view text, std::string_view word, std::string_view value) {
    const auto known = std::ranges::find(kHeaderWords, word, &HeaderWord::word);
    if (known == kHeaderWords.end()) return report_unknown(line, column, word);
    const int value_column = column + static_cast<int>(word.size()) + 1;
    switch (known->kind) {
      case WordKind::Passed:
        return pass_on(line, text);
      case WordKind::Refused:
        reporter_.report(Code::NotSupported,
                         line,
                         column,
                         quoted(text) + " may move a zero in a way that the manual does not state",
                         "the zero set at the machine, or G93X#Y#");
        return;
      case WordKind::Handled:
        break;
    }
    if (word == "INCH" || word == "METRIC") return read_unit(line, column, word, value);
    if (word == "ICI") return read_switch(line, value_column, value, header_.incremental);
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
      const auto done = read_text_offset(value, header_.format, offset_mm);
      if (!done) return bad(line, value_column, value, done.error());
      header_.text_offset = displacement_mm<frame::Programmed>(offset_mm);
      return;
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
    bad(line, value_column, value, word == "VER" ? "VER,1 to VER,8" : "FMAT,1 or FMAT,2");
  }

  void bad(int line, int column, std::string_view text, std::string expected) {
    reporter_.report(Code::ArgumentInvalid, line, column, quoted(text), std::move(expected));
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
                          block.arguments_column == 0;
    for (int axis = 0; axis < 2 && is_point; ++axis) {
      const Word& word = block.words[static_cast<std::size_t>(axis)];
      const ParsedLength parsed = parse_length(word.number, header_.format);
      if (parsed.fault != NumberFault::None) {
        return reporter_.report_number(
            parsed.fault, word.number, line, word.column + 1, header_.format);
      }
      zero_mm[axis] = parsed.value.in_mm();
    }
    if (!is_point) return bad(line, column, value, "X#Y#");
    out = displacement_mm<frame::Programmed>(zero_mm);
    has_dimension_ = true;
    if (&out != &header_.zero_correction) return;  // the zero set is an operation of its own
    const Eigen::Vector2d written = zero_mm / header_.format.one_unit().in_mm();
    pass_on(line, fmt::format("ZC,X{}Y{}", with_point(written.x()), with_point(written.y())));
  }

  /// CP,index,diameter.
  void read_compensation(int line, int column, std::string_view value) {
    const auto comma = value.find(',');
    const auto index = parse_count(value.substr(0, comma));
    const ParsedLength diameter = comma == std::string_view::npos
                                      ? ParsedLength{{}, NumberFault::Malformed}
                                      : parse_length(value.substr(comma + 1), header_.format);
    if (!index || *index < 1 || *index > 99 || comma + 1 == value.size() ||
        diameter.fault != NumberFault::None) {
      return bad(line, column, value, "CP,index,diameter with an index from 1 to 99");
    }
    header_.compensation_values[*index] = diameter.value;
    has_dimension_ = true;
    // With a decimal point, since outputs may have other digits.
    const double written = diameter.value / header_.format.one_unit();
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
    std::array<std::string_view, kHeaderWords.size()> words;
    std::ranges::transform(kHeaderWords, words.begin(), &HeaderWord::word);
    const std::string_view near = nearest_word(word, words);
    reporter_.report(Code::HeaderWordUnknown,
                     line,
                     column,
                     quoted(word),
                     near.empty() ? "a command of the manual's header table"
                                  : "did you mean " + quoted(near) + "?");
  }

  void read_unit(int line, int column, std::string_view word, std::string_view value) {
    NumberFormat& format = header_.format;
    if (!unit_word_.empty() && unit_word_ != word) {
      reporter_.report(Code::ArgumentInvalid,
                       line,
                       column,
                       quoted(word) + " contradicts the " + unit_word_ + " before it",
                       "one unit for the whole program");
    }
    if (has_dimension_) {
      reporter_.report(Code::ArgumentInvalid,
                       line,
                       column,
                       quoted(word) + " comes behind numbers whose unit it states",
                       "INCH or METRIC before all dimensions");
    }
    unit_word_ = word;
    format.unit = word == "INCH" ? LengthUnit::Inch : LengthUnit::Millimeter;
    if (!digits_from_hint_) default_digits();
    header_.states_format = true;
    header_.format_evidence = "line " + std::to_string(line) + ": " + std::string(word);
    int value_column = column + static_cast<int>(word.size()) + 1;
    while (!value.empty()) {
      const auto comma = value.find(',');
      const std::string_view part = value.substr(0, comma);
      if (part == "LZ") {
        format.zeros = Zeros::LeadingKept;
        has_zeros_word_ = header_.states_zeros = true;
      } else if (part == "TZ") {
        format.zeros = Zeros::TrailingKept;
        has_zeros_word_ = header_.states_zeros = true;
      } else if (is_digit_mask(part)) {
        has_digit_mask_ = true;
        format.integer_digits = static_cast<int>(part.find('.'));
        format.decimal_digits = static_cast<int>(part.size()) - format.integer_digits - 1;
      } else {
        reporter_.report(Code::ArgumentInvalid,
                         line,
                         value_column,
                         quoted(part),
                         "LZ, TZ or digits such as 000.000");
      }
      header_.format_evidence += "," + std::string(part);
      if (comma == std::string_view::npos) return;
      value.remove_prefix(comma + 1);
      value_column += static_cast<int>(comma) + 1;
    }
  }

  /// CAM systems say in comments what their header does not: `;FILE_FORMAT=4:4` and
  /// `; FORMAT={3:3/ absolute / metric / suppress leading zeros}`.
  void read_comment(int line, std::string_view text) {
    if (const auto at = text.find("FILE_FORMAT="); at != std::string_view::npos) {
      take_digits(line, trim(text.substr(at + 12)), text);
      return;
    }
    const auto at = text.find("FORMAT={");
    if (at == std::string_view::npos) return;
    const std::string_view body = text.substr(at + 8, text.find('}', at) - at - 8);
    take_digits(line, trim(body.substr(0, body.find('/'))), text);
    take_unit(line, body, text);
    const bool suppress_leading = body.find("suppress leading") != std::string_view::npos;
    const bool suppress_trailing = body.find("suppress trailing") != std::string_view::npos;
    if (body.find("incremental") != std::string_view::npos) header_.incremental = true;
    if (has_zeros_word_) return;  // the header's own LZ or TZ rules over a comment
    header_.states_zeros |= suppress_leading || suppress_trailing;
    if (suppress_leading) header_.format.zeros = Zeros::TrailingKept;
    if (suppress_trailing) header_.format.zeros = Zeros::LeadingKept;
  }

  /// INCH and METRIC in the header rule over a comment.
  void take_unit(int line, std::string_view hint, std::string_view comment) {
    const bool is_inch = hint.find("inch") != std::string_view::npos;
    const bool is_metric = hint.find("metric") != std::string_view::npos;
    if (is_inch == is_metric || header_.states_format) return;
    header_.format.unit = is_inch ? LengthUnit::Inch : LengthUnit::Millimeter;
    if (!digits_from_hint_) default_digits();
    header_.states_format = true;
    header_.format_evidence = "line " + std::to_string(line) + ": " + std::string(comment);
  }

  void default_digits() {
    const bool is_inch = header_.format.unit == LengthUnit::Inch;
    header_.format.integer_digits = is_inch ? 2 : 3;
    header_.format.decimal_digits = is_inch ? 4 : 3;
  }

  void take_digits(int line, std::string_view digits, std::string_view comment) {
    const auto pair = digit_pair(digits);
    // `-:-` says that every number has its point; the header's own digits rule over a comment.
    if (!pair || has_digit_mask_) return;
    header_.format.integer_digits = pair->first;
    header_.format.decimal_digits = pair->second;
    header_.format_evidence = "line " + std::to_string(line) + ": " + std::string(comment);
    header_.states_digits = true;
    digits_from_hint_ = true;
  }

  void read_tool(const SourceLine& line) {
    Block block;
    if (const auto fault = lex(line, block)) {
      reporter_.report(Code::BlockSyntax,
                       line.number,
                       fault->column,
                       quoted(fault->text),
                       std::string(fault->expected));
      return;
    }
    const auto tool = read_tool_block(block, {header_.format, nullptr, diameter_page_}, reporter_);
    if (!tool) return;
    has_dimension_ |= tool->tool.diameter.has_value() || tool->tool.depth_offset.has_value();
    header_.tool_lines.emplace(tool->tool.number, line.number);
    Tool merged = tool->tool;
    Tool& known = header_.tools.try_emplace(merged.number, merged).first->second;
    fill_missing(merged, known);
    const Tool latest = merged;
    fill_missing(known, merged);
    if (latest == known) return;
    reporter_.report(Code::ArgumentInvalid,
                     line.number,
                     block.column,
                     quoted(block.text) + " defines the tool differently from before",
                     "one definition of each tool");
  }

  void read_switch(int line, int column, std::string_view value, bool& state) {
    if (!value.empty() && value != "ON" && value != "OFF") {
      reporter_.report(Code::ArgumentInvalid, line, column, quoted(value), "ON or OFF");
    }
    state = value != "OFF";
  }

  /// R,T resets the tool data that came so far.
  void pass_on(int line, std::string_view text) {
    if (text == "R,T") {
      header_.tools.clear();
      header_.tool_lines.clear();
    }
    header_.settings.push_back({line, std::string(text)});
  }

  LineCursor cursor_;
  Reporter reporter_;
  const std::vector<Tool>& diameter_page_;
  Header header_;
  int start_line_ = 0;
  bool digits_from_hint_ = false;
  bool has_zeros_word_ = false;
  bool has_dimension_ = false;
  bool has_digit_mask_ = false;
  std::string unit_word_;
};

}  // namespace

std::vector<HeaderWordInfo> header_word_table() {
  using enum CommandClass;
  constexpr std::array<std::string_view, 3> kKinds = {"handled", "passed", "refused"};
  return {
#define EXCELLON_HEADER_WORD(word, command_class, effect, kind) \
  HeaderWordInfo{word, command_class, effect, kKinds[static_cast<std::size_t>(WordKind::kind)]},
#include "program/excellon/text/header_words.def"
  };
}

Header read_header(const SourceText& source,
                   const std::vector<Tool>& diameter_page,
                   DiagnosticLog& log) {
  return HeaderReader(source, diameter_page, log).read();
}

tl::expected<void, std::string> read_text_offset(std::string_view value,
                                                 const NumberFormat& format,
                                                 Eigen::Vector2d& offset_mm) {
  const auto comma = value.find(',');
  const ParsedLength x = parse_length(value.substr(0, comma), format);
  ParsedLength y;
  if (comma != std::string_view::npos) y = parse_length(value.substr(comma + 1), format);
  if (value.empty() || x.fault != NumberFault::None || y.fault != NumberFault::None) {
    return tl::make_unexpected("CAN_TEXT_OFF,x or CAN_TEXT_OFF,x,y");
  }
  offset_mm.x() = x.value.in_mm();
  if (comma != std::string_view::npos) offset_mm.y() = y.value.in_mm();
  return {};
}

const Header& header_of(const Program& program) {
  return static_cast<const Header&>(*program.head);
}

}  // namespace panelcal::excellon
