// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "panelcal/program/source_text.h"

namespace panelcal::excellon {

enum class Command : std::uint8_t {
#define EXCELLON_COMMAND(name, letter, number, state, operands, section) name,
#include "panelcal/program/excellon/commands.def"
};

struct CommandInfo {
  Command command;
  char letter;
  int number;
  bool runs;
  std::string_view operands;
  std::string_view section;
};

/// The command table in the order of commands.def.
std::span<const CommandInfo> command_table();
const CommandInfo& info(Command command);
std::optional<Command> find_command(char letter, int number);

/// A letter and what follows it, such as `X` and `-0087`.
struct Word {
  char letter = 0;
  int column = 0;           ///< of the letter, from 1
  std::string_view number;  ///< may be empty
};

/// One program line as words, left to right.
struct Block {
  static constexpr std::size_t kMaxWords = 16;

  int line = 0;
  std::string_view text;  ///< the line without blanks at either end
  int column = 1;         ///< of the first character of text
  std::array<Word, kMaxWords> words;
  std::size_t n_words = 0;
  std::string_view arguments;  ///< what follows the first comma
  int arguments_column = 0;    ///< 0: there is no comma

  std::span<const Word> all() const { return {words.data(), n_words}; }
  const Word* find(char letter) const;
};

enum class LineKind : std::uint8_t {
  Empty,          ///< blank, or a comment
  PatternMark,    ///< a lone %
  BlockDelete,    ///< begins with /
  KeyboardOrder,  ///< begins with $
  Words,
};

LineKind kind_of(std::string_view line);

struct LexFault {
  int column = 0;
  std::string_view text;  ///< the offending characters
  std::string_view expected;
};

/// Splits a line of kind Words. A word is a letter A to Z and characters of `+-.0123456789`; a
/// comma ends the words. Blanks between words are skipped.
std::optional<LexFault> lex(const SourceLine& line, Block& block);

}  // namespace panelcal::excellon
