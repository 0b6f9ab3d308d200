// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/lexer.h"

#include <algorithm>
#include <array>

namespace panelcal::excellon {
namespace {

constexpr bool Runs = true;
constexpr bool Later = false;
constexpr std::array kCommands = {
#define EXCELLON_COMMAND(name, letter, number, state, operands, section) \
  CommandInfo{Command::name, letter, number, state, operands, section},
#include "panelcal/program/excellon/commands.def"
};

constexpr int kCodes = 100;  // G00..G99, M00..M99
using CodeIndex = std::array<std::int8_t, kCodes>;

constexpr CodeIndex index_of_letter(char letter) {
  CodeIndex index{};
  index.fill(-1);
  for (std::size_t i = 0; i < kCommands.size(); ++i) {
    if (kCommands[i].letter == letter) index[kCommands[i].number] = static_cast<std::int8_t>(i);
  }
  return index;
}
constexpr CodeIndex kIndexOfG = index_of_letter('G');
constexpr CodeIndex kIndexOfM = index_of_letter('M');

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}
bool is_letter(char c) {
  return c >= 'A' && c <= 'Z';
}
bool is_number_part(char c) {
  return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
}

}  // namespace

std::span<const CommandInfo> command_table() {
  return kCommands;
}

const CommandInfo& info(Command command) {
  return kCommands[static_cast<std::size_t>(command)];
}

std::optional<Command> find_command(char letter, int number) {
  if (number < 0 || number >= kCodes) return std::nullopt;
  const int i = letter == 'G' ? kIndexOfG[number] : letter == 'M' ? kIndexOfM[number] : -1;
  if (i < 0) return std::nullopt;
  return kCommands[static_cast<std::size_t>(i)].command;
}

const Word* Block::find(char letter) const {
  const auto found = std::ranges::find(all(), letter, &Word::letter);
  return found == all().end() ? nullptr : &*found;
}

LineKind kind_of(std::string_view line) {
  const auto first = std::ranges::find_if_not(line, is_blank);
  if (first == line.end() || *first == ';') return LineKind::Empty;
  if (*first == '/') return LineKind::BlockDelete;
  if (*first == '$') return LineKind::KeyboardOrder;
  if (*first == '%' && std::all_of(first + 1, line.end(), is_blank)) return LineKind::PatternMark;
  return LineKind::Words;
}

std::optional<LexFault> lex(const SourceLine& line, Block& block) {
  const std::string_view text = line.text;
  std::size_t i = 0;
  std::size_t end = text.size();
  while (i < end && is_blank(text[i])) ++i;
  while (end > i && is_blank(text[end - 1])) --end;

  block.line = line.number;
  block.text = text.substr(i, end - i);
  block.column = static_cast<int>(i) + 1;
  block.n_words = 0;
  block.arguments = {};
  block.arguments_column = 0;
  while (i < end) {
    const int column = static_cast<int>(i) + 1;
    if (text[i] == ',') {
      block.arguments = text.substr(i + 1, end - i - 1);
      block.arguments_column = column + 1;
      return std::nullopt;
    }
    if (!is_letter(text[i])) return LexFault{column, text.substr(i, 1), "a letter A to Z"};
    if (block.n_words == Block::kMaxWords) {
      return LexFault{column, text.substr(i, end - i), "at most 16 words in a block"};
    }
    const std::size_t begin = ++i;
    while (i < end && is_number_part(text[i])) ++i;
    block.words[block.n_words++] = {text[begin - 1], column, text.substr(begin, i - begin)};
    while (i < end && is_blank(text[i])) ++i;
  }
  return std::nullopt;
}

}  // namespace panelcal::excellon
