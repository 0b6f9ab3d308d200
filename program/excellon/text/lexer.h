// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "program/model/command_class.h"
#include "program/text/block.h"
#include "program/text/source_text.h"
#include "program/text/word.h"

namespace panelcal::excellon {

enum class Command : std::uint8_t {
#define EXCELLON_COMMAND(name, ...) name,
#include "program/excellon/text/commands.def"
};

struct CommandInfo {
  Command command;
  char letter;
  int number;
  CommandClass command_class;
  std::string_view operands;
  std::string_view section;
  std::string_view effect;
  std::string_view test;
};

/// A form of block or word that has no code of its own, such as `R#X#Y#`.
struct WordInfo {
  std::string_view form;
  CommandClass command_class;
  std::string_view section;
  std::string_view effect;
  std::string_view test;
};

/// The command table in the order of commands.def.
std::span<const CommandInfo> command_table();
std::span<const WordInfo> word_table();
const CommandInfo& info(Command command);
std::optional<Command> find_command(char letter, int number);
/// A code that Format One uses for a command of Format Two.
/// Source CNC-7 manual, List of Equivalent Format One Commands
struct FormatOneInfo {
  char letter;
  int number;
  Command command;
};
std::span<const FormatOneInfo> format_one_table();

/// G02, M30 and so on, as the manual writes it.
std::string code_text(Command command);

/// The one of the two command sets of the manual's table of equivalents a program is written in.
enum class ProgramSet : std::uint8_t { FormatOne, FormatTwo };

/// The command that a G or M word of one or two digits stands for. `G045` is not one: taken for G45
/// it would measure a target that was not meant.
/// Source CNC-7 manual, List of Equivalent Format One Commands
std::optional<Command> command_of(const Word& word, ProgramSet set);

/// One program line. Its argument is the text behind the first comma.
using Block = WordBlock<16>;

/// The words [begin, end) of a block as a block of their own.
///
/// Precondition: begin < end <= n_words, and no comma
Block part_of(const Block& block, std::size_t begin, std::size_t end);

enum class LineKind : std::uint8_t {
  Empty,          ///< blank, or a comment
  PatternMark,    ///< a lone %
  BlockDelete,    ///< begins with /
  KeyboardOrder,  ///< begins with $
  Words,
};

LineKind kind_of(std::string_view line);

/// The line without blanks at either end, its column moved.
SourceLine without_blanks(const SourceLine& line);

/// The line behind the slash of block delete: `/X1Y1` as `X1Y1`, places kept.
SourceLine without_slash(const SourceLine& line);

/// `M45,text\`: the message goes on in the next line.
bool is_continued(std::string_view line);
/// A line that begins a long message.
bool is_long_message(std::string_view line);
/// Moves behind the lines that go on with the message begun by `first`.
void skip_message(LineCursor& cursor, std::string_view first);

/// Splits a line of kind Words. A word is a letter A to Z and characters of `+-.0123456789`; a
/// comma ends the words. Blanks between words are skipped.
std::optional<LexFault> lex(const SourceLine& line, Block& block);

}  // namespace panelcal::excellon
