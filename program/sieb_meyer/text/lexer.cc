// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/lexer.h"

#include <cstddef>

#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr auto kSiebMeyerCommands = std::to_array<CommandInfo>({
#define SIEB_MEYER_COMMAND(                                                        \
    name, letter, number, kind, operands, formats, section, effect, test, meaning) \
  {Command::name, letter, number, CommandClass::kind, operands, formats, section, effect, test},
#include "program/sieb_meyer/text/commands.def"
});

constexpr auto kSiebMeyerWords = std::to_array<WordInfo>({
#define SIEB_MEYER_WORD(form, kind, formats, section, effect, test) \
  {form, CommandClass::kind, formats, section, effect, test},
#include "program/sieb_meyer/text/commands.def"
});

constexpr std::size_t kSiebMeyerCodes = 100;

/// Index into kCommands by the code's number, one more so that zero means no command.
using SiebMeyerIndex = std::array<std::uint8_t, kSiebMeyerCodes>;

constexpr SiebMeyerIndex index_of(char letter) {
  SiebMeyerIndex index{};
  for (std::size_t i = 0; i < kSiebMeyerCommands.size(); ++i) {
    if (kSiebMeyerCommands[i].letter != letter) continue;
    index[static_cast<std::size_t>(kSiebMeyerCommands[i].number)] =
        static_cast<std::uint8_t>(i + 1);
  }
  return index;
}
constexpr SiebMeyerIndex kGCodes = index_of('G');
constexpr SiebMeyerIndex kMCodes = index_of('M');

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_number_character(char c) {
  return is_digit(c) || c == '+' || c == '-' || c == '.';
}

bool takes_text(Command command) {
  switch (command) {
    case Command::UserMessage:
    case Command::CncCommand:
    case Command::CameraText:
    case Command::DeviceText:
    case Command::TextX:
    case Command::TextY:
    case Command::Subprogram:
    case Command::CameraByte:
    case Command::CorrectionValues:
      return true;
    default:
      return false;
  }
}

/// Commands, names and numbers have no brackets; what is shown, drilled or sent may.
bool may_have_brackets(Command command) {
  return command != Command::CncCommand && command != Command::Subprogram &&
         command != Command::CameraByte && command != Command::CorrectionValues;
}

/// Text behind the comments that it begins with; one that is not closed goes on to the end.
std::string_view behind_comments(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(') {
      ++depth;
    } else if (depth == 0 && !is_gap(text[i])) {
      return text.substr(i);
    } else if (text[i] == ')' && depth > 0) {
      --depth;
    }
  }
  return {};
}

}  // namespace

std::span<const CommandInfo> command_table() {
  return kSiebMeyerCommands;
}

std::span<const WordInfo> word_table() {
  return kSiebMeyerWords;
}

const CommandInfo& info(Command command) {
  return kSiebMeyerCommands.at(static_cast<std::size_t>(command));
}

std::string code_text(Command command) {
  const CommandInfo& row = info(command);
  return fmt::format("{}{}", row.letter, row.number);
}

std::optional<Command> command_of(const Word& word) {
  if (word.number.empty() || word.number.size() > 2) return std::nullopt;
  std::size_t number = 0;
  for (const char c : word.number) {
    if (!is_digit(c)) return std::nullopt;
    number = number * 10 + static_cast<std::size_t>(c - '0');
  }
  const std::uint8_t found = (word.letter == 'G' ? kGCodes : kMCodes).at(number);
  if (found == 0) return std::nullopt;
  return kSiebMeyerCommands.at(found - 1U).command;
}

bool is_offset(Command command) {
  return command == Command::Offset || command == Command::OffsetTurned ||
         command == Command::OffsetMirrorX || command == Command::OffsetMirrorY ||
         command == Command::OffsetHalfTurn;
}

bool is_routing(Command command) {
  switch (command) {
    case Command::RoutLine:
    case Command::RoutClockwise:
    case Command::RoutCounterclockwise:
    case Command::CircleCounterclockwise:
    case Command::CircleClockwise:
    case Command::DiskCounterclockwise:
    case Command::DiskClockwise:
    case Command::RectangleCounterclockwise:
    case Command::RectangleClockwise:
      return true;
    default:
      return false;
  }
}

bool is_camera(Command command) {
  switch (command) {
    case Command::CorrectionOff:
    case Command::CorrectionOn:
    case Command::Measure:
    case Command::FinishMeasure:
    case Command::CorrectionClear:
    case Command::CameraByte:
    case Command::MeasureOffset:
    case Command::CorrectionValues:
    case Command::CameraText:
      return true;
    default:
      return false;
  }
}

std::optional<LexFault> lex(const SourceLine& line, Block& block) {
  block.line = line.number;
  block.text = trimmed(line.text);
  const auto column_of = [&line](const char* at) {
    return line.column + static_cast<int>(at - line.text.data());
  };
  block.column = column_of(block.text.data());
  block.n_words = 0;
  block.argument = {};
  block.argument_column = 0;
  std::string_view rest = block.text;
  while (true) {
    while (!rest.empty() && is_gap(rest.front())) rest.remove_prefix(1);
    if (rest.empty()) return std::nullopt;
    if (rest.front() == '(') {
      const std::string_view behind = behind_comments(rest);
      if (behind.empty()) return std::nullopt;
      return LexFault{column_of(behind.data()), behind, "nothing behind a comment"};
    }
    const char letter = rest.front();
    if (letter < 'A' || letter > 'Z') {
      return LexFault{column_of(rest.data()), rest.substr(0, 1), "a capital letter with a number"};
    }
    if (block.n_words == Block::kMaxWords) {
      return LexFault{column_of(rest.data()), rest, "at most 32 words in a line"};
    }
    std::size_t n = 1;
    while (n < rest.size() && is_number_character(rest[n])) ++n;
    const Word word{letter, column_of(rest.data()), rest.substr(1, n - 1)};
    block.words[block.n_words++] = word;
    rest.remove_prefix(n);
    if (letter != 'G' && letter != 'M') continue;
    const auto command = command_of(word);
    if (!command || !takes_text(*command)) continue;
    std::string_view text = trimmed(rest);
    if (text.empty()) return std::nullopt;
    if (text.front() == ',') {
      text = trimmed(text.substr(1));
    } else if (*command != Command::UserMessage) {
      return LexFault{column_of(text.data()), text, "a comma before the text"};
    }
    if (!may_have_brackets(*command)) text = trimmed(text.substr(0, text.find('(')));
    block.argument = text;
    block.argument_column = column_of(text.data());
    return std::nullopt;
  }
}

bool is_blank(std::string_view line) {
  line = trimmed(line);
  return line.empty() || (line.front() == '(' && behind_comments(line).empty());
}

std::optional<SourceLine> without_slash(const SourceLine& line) {
  const std::string_view text = trimmed(line.text);
  if (text.empty() || text.front() != '/') return std::nullopt;
  const int at = static_cast<int>(text.data() - line.text.data());
  return SourceLine{text.substr(1), line.number, line.column + at + 1};
}

}  // namespace panelcal::sieb_meyer
