// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/file_layout.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "program/sieb_meyer/text/format_setting.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/text/gaps.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::string_view kBlanks = " \t";

/// Reads the lines behind the $.
class TableReader {
 public:
  TableReader(FileLayout& layout, const Reporter& reporter)
      : layout_(layout), reporter_(reporter) {}

  void read(LineCursor cursor) {
    const SourceLine first = cursor.next();
    if (layout_.format == FileFormat::F1000) return read_fixed(first, cursor);
    if (trimmed(first.text) != "$") {
      refuse(first.number, first.column, quoted(first.text), "a $ alone in its line");
      return;
    }
    bool is_closed = false;
    int last_line = first.number;
    while (!cursor.at_end()) {
      const SourceLine line = cursor.next();
      last_line = line.number;
      const std::string_view text = trimmed(line.text);
      if (text.empty()) continue;
      if (is_closed) {
        reporter_.report(
            Code::TextAfterEnd, line.number, quoted(line.text), "nothing behind the tool table");
        return;
      }
      if (text == "$") {
        is_closed = true;
      } else {
        read_line(line);
      }
    }
    if (!is_closed) refuse(last_line, 0, "the tool table has no end", "a closing $");
  }

 private:
  void refuse(int line, int column, std::string_view text, std::string expected) {
    reporter_.report(Code::ToolTableInvalid, line, column, std::string(text), std::move(expected));
  }
  void refuse(int line, const Word& word, std::string expected) {
    refuse(line, word.column, quoted(word.text()), std::move(expected));
  }

  int most_tools() const {
    return layout_.format == FileFormat::F1000 ? 15 : layout_.format == FileFormat::F3000 ? 30 : 99;
  }

  void read_line(const SourceLine& line) {
    if (trimmed(line.text).starts_with('M')) return read_magazines(line);
    Block block;
    if (const auto fault = lex(line, block)) {
      return refuse(line.number, fault->column, quoted(fault->text), std::string(fault->expected));
    }
    if (block.n_words == 0) return;
    if (block.words[0].letter != 'T') {
      return refuse(line.number, block.words[0], "T# with the tool's data, M# or $");
    }
    const auto number = parse_count(block.words[0].number);
    if (!number || *number < 1 || *number > most_tools()) {
      return refuse(line.number, block.words[0], fmt::format("T1 to T{}", most_tools()));
    }
    tool_ = *number;
    Tool& tool = layout_.tools[tool_];
    tool.number = tool_;
    layout_.tool_lines[tool_] = line.number;
    for (const Word& word : block.all().subspan(1)) {
      if (!read_datum(line.number, word, tool)) return;
    }
  }

  /// `M46M47`: not read as words of a program, where M47 takes a text.
  void read_magazines(const SourceLine& line) {
    constexpr int kMostMagazines = 999;
    const std::string_view text = line.text;
    std::size_t at = text.find_first_not_of(kBlanks);
    while (at < text.size()) {
      const auto end = std::min(text.find_first_not_of("0123456789", at + 1), text.size());
      const Word word{
          text[at], line.column + static_cast<int>(at), text.substr(at + 1, end - at - 1)};
      const auto number = parse_count(word.number);
      if (word.letter != 'M' || !number || *number < 1 || *number > kMostMagazines) {
        return refuse(line.number, word, "M# with the number of a magazine");
      }
      if (tool_ == 0) return refuse(line.number, word, "a tool before its magazines");
      layout_.tools[tool_].magazines.push_back(*number);
      at = std::min(text.find_first_not_of(kBlanks, end), text.size());
    }
  }

  bool read_datum(int line, const Word& word, Tool& tool) {
    switch (word.letter) {
      case 'D':
        return read_value(line, word, Quantity::ToolDiameter, tool, [&](double v) {
          tool.diameter = datum(v, mm(v));
        });
      case 'S':
        return read_value(line, word, Quantity::ToolSpeed, tool, [&](double v) {
          tool.speed = datum(v, rpm(v * 1000));
        });
      case 'F':
      case 'R':
        return read_value(line, word, Quantity::ToolFeed, tool, [&](double v) {
          (word.letter == 'F' ? tool.infeed : tool.retract) = datum(v, mm_per_s(v * 1000 / 60));
        });
      case 'N':
        return read_life(line, word, tool);
      case 'A':
        return read_value(line, word, Quantity::ToolDwell, tool, [&](double v) {
          tool.dwell = datum(v, seconds(v / 1000));
        });
      case 'Z':
        if (layout_.format == FileFormat::F5000) {
          return read_value(line, word, Quantity::ToolZOffset, tool, [&](double v) {
            tool.depth_offset = datum(v, mm(v));
          });
        }
        [[fallthrough]];
      default:
        refuse(
            line,
            word,
            layout_.format == FileFormat::F5000 ? "D, S, F, R, N, A or Z" : "D, S, F, R, N or A");
        return false;
    }
  }

  bool read_life(int line, const Word& word, Tool& tool) {
    bool fits = false;
    const bool is_read = read_value(line, word, Quantity::ToolLife, tool, [&](double v) {
      fits = v <= std::numeric_limits<int>::max();
      if (fits) tool.max_hits = datum(v, static_cast<int>(v));
    });
    if (is_read && !fits) refuse(line, word, "fewer strokes");
    return is_read && fits;
  }

  /// Zero says that there is none.
  template <class T>
  static std::optional<T> datum(double value, T quantity) {
    return value == 0 ? std::nullopt : std::optional<T>(quantity);
  }

  template <class Set>
  bool read_value(int line, const Word& word, Quantity quantity, Tool& tool, Set set) {
    const ParsedNumber number = parse_number(word.number, layout_.numbers, quantity);
    if (number.problem != NumberProblem::None) {
      reporter_.report(is_open(number.problem) ? Code::FormatAmbiguous : Code::ToolTableInvalid,
                       line,
                       word.column,
                       quoted(word.text()),
                       expectation(number.problem, layout_.numbers, quantity));
      return false;
    }
    set(number.value);
    std::erase(tool.zeroed, word.letter);
    if (number.value == 0) tool.zeroed += word.letter;
    return true;
  }

  /// `$80$55$12$99$30$300$200...`: D S F R N A of 15 tools; line ends inside do not count.
  void read_fixed(const SourceLine& first, LineCursor cursor) {
    constexpr int kTools = 15;
    constexpr std::string_view kLetters = "DSFRNA";
    std::string text(trimmed(first.text));
    while (!cursor.at_end()) text += trimmed(cursor.next().text);
    std::size_t n_values = 0;
    std::size_t at = 1;
    std::map<int, std::string> without_value;
    while (at < text.size()) {
      const auto end = text.find('$', at);
      if (end == std::string::npos) {
        return refuse(first.number, 0, quoted(text.substr(at)), "a $ behind every value");
      }
      const Word word{kLetters[n_values % kLetters.size()],
                      first.column,
                      std::string_view(text).substr(at, end - at)};
      const int number = static_cast<int>(n_values / kLetters.size()) + 1;
      if (number > kTools) break;
      if (word.number.empty()) {
        without_value[number] += word.letter;
      } else {
        Tool& tool = layout_.tools[number];
        tool.number = number;
        layout_.tool_lines[number] = first.number;
        if (!read_datum(first.number, word, tool)) return;
      }
      ++n_values;
      at = end + 1;
    }
    if (n_values != kTools * kLetters.size() || at < text.size()) {
      refuse(first.number,
             first.column,
             fmt::format("{} values behind the first $", n_values + (at < text.size() ? 1 : 0)),
             "six for each of 15 tools, 91 dollar signs in all");
    }
    for (int number = 1; number <= kTools; ++number) {
      const auto valued = layout_.tools.find(number);
      Tool& tool = valued == layout_.tools.end() ? layout_.empty_tools[number] : valued->second;
      tool.number = number;
      tool.magazines = {number};
      tool.zeroed += without_value[number];
    }
  }

  FileLayout& layout_;
  const Reporter& reporter_;
  int tool_ = 0;
};

/// The place of a line that begins at `offset`.
LinePlace line_place_of(std::string_view bytes, LinePlace from, std::size_t offset) {
  const std::string_view before = bytes.substr(from.offset, offset - from.offset);
  if (before.find('\r') == std::string_view::npos) {
    return {offset, from.number + static_cast<int>(count_line_feeds(before))};
  }
  LineCursor cursor(bytes, from);
  while (cursor.offset() < offset) cursor.next();
  return {offset, cursor.line_number()};
}

/// The line that begins with a $, if there is one.
std::optional<LinePlace> find_table(std::string_view bytes, LinePlace from) {
  for (auto at = bytes.find('$', from.offset); at != std::string_view::npos;
       at = bytes.find('$', at + 1)) {
    const auto before = bytes.find_last_not_of(kBlanks, at - 1);
    if (bytes[before] == '\n' || bytes[before] == '\r')
      return line_place_of(bytes, from, before + 1);
  }
  return std::nullopt;
}

}  // namespace

Tool FileLayout::taken_tool(int number) const {
  for (const auto* table : {&tools, &empty_tools}) {
    if (const auto found = table->find(number); found != table->end()) return found->second;
  }
  return Tool{.number = number};
}

bool is_program(std::string_view bytes) {
  LineCursor cursor(bytes);
  while (!cursor.at_end()) {
    const std::string_view text = trimmed(cursor.next().text);
    if (text.starts_with("%%")) return true;
    if (text.starts_with('%') || text == "M48") return false;
  }
  return false;
}

FileLayout read_layout(const SourceText& source, DiagnosticLog& log, const ReadOptions& reading) {
  const Reporter reporter(source.file, log);
  FileLayout layout;
  LineCursor cursor(source.bytes);
  while (!cursor.at_end()) {
    const SourceLine line = cursor.next();
    const std::string_view mark = trimmed(line.text);
    if (!mark.starts_with("%%")) continue;
    layout.head_line = line.number;
    layout.body = cursor.place();
    if (const auto stated = parse_format_mark(mark)) {
      const auto choice = choose_format(*stated, mark, line.number, line.column, reading, reporter);
      layout.format = stated->file;
      layout.numbers = choice.format;
      layout.setting = stated->setting;
      layout.format_evidence = choice.evidence;
      layout.subprograms = choice.subprograms;
    } else {
      reporter.report(
          Code::CommandFormat, line.number, line.column, quoted(mark), "%%, %%3000 or %%5000");
    }
    break;
  }
  layout.body_end = source.bytes.size();
  if (const auto table = find_table(source.bytes, cursor.place())) {
    layout.body_end = table->offset;
    TableReader(layout, reporter).read(LineCursor(source.bytes, *table));
  } else {
    reporter.report_end_missing(source.bytes, "$ and the tool table");
  }
  return layout;
}

std::string FileLayout::reading() const {
  return fmt::format("{}, {} (line {}{}{})",
                     name(Dialect::SiebMeyer),
                     number_summary(),
                     head_line,
                     format_evidence.empty() ? "" : "; ",
                     format_evidence);
}

const FileLayout& layout_of(const Program& program) {
  return static_cast<const FileLayout&>(*program.head);
}

}  // namespace panelcal::sieb_meyer
