// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/lexer.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "program/text/gaps.h"
#include "program/text/number_format.h"

namespace panelcal::excellon {
namespace {

constexpr auto kExcellonCommands = [] {
  using enum CommandClass;
  return std::array{
#define EXCELLON_COMMAND(name, letter, number, kind, operands, section, effect, test, handler) \
  CommandInfo{Command::name, letter, number, kind, operands, section, effect, test},
#include "program/excellon/text/commands.def"
  };
}();
constexpr auto kExcellonWords = [] {
  using enum CommandClass;
  return std::array{
#define EXCELLON_WORD(form, kind, section, effect, test) \
  WordInfo{form, kind, section, effect, test},
#include "program/excellon/text/commands.def"
  };
}();

constexpr int kExcellonCodes = 100;  // G00..G99, M00..M99
using ExcellonIndex = std::array<std::int8_t, kExcellonCodes>;

constexpr ExcellonIndex index_of_letter(char letter) {
  ExcellonIndex index{};
  index.fill(-1);
  for (std::size_t i = 0; i < kExcellonCommands.size(); ++i) {
    if (kExcellonCommands[i].letter == letter)
      index[kExcellonCommands[i].number] = static_cast<std::int8_t>(i);
  }
  return index;
}
constexpr ExcellonIndex kIndexOfG = index_of_letter('G');
constexpr ExcellonIndex kIndexOfM = index_of_letter('M');

bool is_capital(char c) {
  return c >= 'A' && c <= 'Z';
}
bool is_number_part(char c) {
  return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
}

/// Codes that mean something else in Format One. A Format Two code that has an equivalent there is
/// not one of Format One's, unless it appears as one itself.
constexpr std::array kFormatOne = {
    FormatOneInfo{'G', 81, Command::DrillMode},
    FormatOneInfo{'M', 2, Command::EndNoRewind},
    FormatOneInfo{'M', 24, Command::EndOfPattern},
    FormatOneInfo{'M', 26, Command::RepeatPattern},
    FormatOneInfo{'M', 1, Command::OptionalStop},
    FormatOneInfo{'M', 27, Command::EndOfRepeat},
    FormatOneInfo{'M', 0, Command::InspectionStop},
    FormatOneInfo{'M', 23, Command::SwapAxes},
    FormatOneInfo{'M', 70, Command::Inch},
    FormatOneInfo{'M', 21, Command::MirrorX},
    FormatOneInfo{'M', 22, Command::MirrorY},
};

}  // namespace

std::span<const CommandInfo> command_table() {
  return kExcellonCommands;
}

std::span<const WordInfo> word_table() {
  return kExcellonWords;
}

std::span<const FormatOneInfo> format_one_table() {
  return kFormatOne;
}

std::string code_text(Command command) {
  const CommandInfo& row = info(command);
  std::string text(1, row.letter);
  if (row.number < 10) text += '0';
  return text + std::to_string(row.number);
}

std::optional<Command> command_of(const Word& word, ProgramSet set) {
  if (word.number.empty() || word.number.size() > 2) return std::nullopt;
  const std::optional<int> number = parse_count(word.number);
  if (!number) return std::nullopt;
  if (set == ProgramSet::FormatTwo) return find_command(word.letter, *number);
  for (const FormatOneInfo& row : kFormatOne) {
    if (row.letter == word.letter && row.number == *number) return row.command;
  }
  const std::optional<Command> command = find_command(word.letter, *number);
  if (command &&
      std::ranges::find(kFormatOne, *command, &FormatOneInfo::command) != kFormatOne.end()) {
    return std::nullopt;
  }
  return command;
}

const CommandInfo& info(Command command) {
  return kExcellonCommands[static_cast<std::size_t>(command)];
}

std::optional<Command> find_command(char letter, int number) {
  if (number < 0 || number >= kExcellonCodes) return std::nullopt;
  const int i = letter == 'G' ? kIndexOfG[number] : letter == 'M' ? kIndexOfM[number] : -1;
  if (i < 0) return std::nullopt;
  return kExcellonCommands[static_cast<std::size_t>(i)].command;
}

Block part_of(const Block& block, std::size_t begin, std::size_t end) {
  Block part;
  part.line = block.line;
  part.n_words = end - begin;
  std::copy_n(
      block.words.begin() + static_cast<std::ptrdiff_t>(begin), part.n_words, part.words.begin());
  part.column = part.words[0].column;
  const Word& last = part.words[part.n_words - 1];
  const auto offset = static_cast<std::size_t>(part.column - block.column);
  const auto size = static_cast<std::size_t>(last.column - part.column) + 1 + last.number.size();
  part.text = block.text.substr(offset, size);
  return part;
}

LineKind kind_of(std::string_view line) {
  const auto first = std::ranges::find_if_not(line, is_gap);
  if (first == line.end() || *first == ';') return LineKind::Empty;
  if (*first == '/') return LineKind::BlockDelete;
  if (*first == '$') return LineKind::KeyboardOrder;
  if (*first == '%' && std::all_of(first + 1, line.end(), is_gap)) return LineKind::PatternMark;
  return LineKind::Words;
}

SourceLine without_blanks(const SourceLine& line) {
  const auto first =
      static_cast<std::size_t>(std::ranges::find_if_not(line.text, is_gap) - line.text.begin());
  std::string_view text = line.text.substr(first);
  while (!text.empty() && is_gap(text.back())) text.remove_suffix(1);
  return {text, line.number, line.column + static_cast<int>(first)};
}

SourceLine without_slash(const SourceLine& line) {
  const auto slash = static_cast<int>(line.text.find('/'));
  return {
      line.text.substr(static_cast<std::size_t>(slash) + 1), line.number, line.column + slash + 1};
}

bool is_continued(std::string_view line) {
  const auto last = line.find_last_not_of(" \t");
  return last != std::string_view::npos && line[last] == '\\';
}

bool is_long_message(std::string_view line) {
  const auto first = std::ranges::find_if_not(line, is_gap);
  return std::string_view(first, line.end()).starts_with("M45,");
}

void skip_message(LineCursor& cursor, std::string_view first) {
  for (bool more = is_continued(first); more && !cursor.at_end();) {
    more = is_continued(cursor.next().text);
  }
}

std::optional<LexFault> lex(const SourceLine& line, Block& block) {
  const std::string_view text = line.text;
  std::size_t i = 0;
  std::size_t end = text.size();
  while (i < end && is_gap(text[i])) ++i;
  while (end > i && is_gap(text[end - 1])) --end;

  block.line = line.number;
  block.text = text.substr(i, end - i);
  block.column = line.column + static_cast<int>(i);
  block.n_words = 0;
  block.argument = {};
  block.argument_column = 0;
  while (i < end) {
    const int column = line.column + static_cast<int>(i);
    if (text[i] == ',') {
      block.argument = text.substr(i + 1, end - i - 1);
      block.argument_column = column + 1;
      return std::nullopt;
    }
    if (!is_capital(text[i])) return LexFault{column, text.substr(i, 1), "a letter A to Z"};
    if (block.n_words == Block::kMaxWords) {
      return LexFault{column, text.substr(i, end - i), "at most 16 words in a block"};
    }
    const std::size_t begin = ++i;
    while (i < end && is_number_part(text[i])) ++i;
    block.words[block.n_words++] = {text[begin - 1], column, text.substr(begin, i - begin)};
    while (i < end && is_gap(text[i])) ++i;
  }
  return std::nullopt;
}

}  // namespace panelcal::excellon
