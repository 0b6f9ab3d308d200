// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "program/model/command_class.h"
#include "program/sieb_meyer/text/numbers.h"
#include "program/text/block.h"
#include "program/text/source_text.h"
#include "program/text/word.h"

namespace panelcal::sieb_meyer {

enum class Command : std::uint8_t {
#define SIEB_MEYER_COMMAND(name, ...) name,
#include "program/sieb_meyer/text/commands.def"
};

struct CommandInfo {
  Command command;
  char letter;
  int number;
  CommandClass command_class;
  std::string_view operands;
  std::string_view formats;  ///< the first digits of those that have it
  std::string_view section;
  std::string_view effect;
  std::string_view test;

  bool exists_in(FileFormat format) const {
    return formats.find(name(format).front()) != std::string_view::npos;
  }
};

/// A form of line or word that has no code of its own, such as `X#Y#`.
struct WordInfo {
  std::string_view form;
  CommandClass command_class;
  std::string_view formats;
  std::string_view section;
  std::string_view effect;
  std::string_view test;
};

/// The command table in the order of commands.def.
std::span<const CommandInfo> command_table();
std::span<const WordInfo> word_table();
const CommandInfo& info(Command command);
/// G2, M50 and so on, as the manual writes it.
std::string code_text(Command command);

/// The command of a G or M word; a leading zero is allowed (`G01`), a third digit is not.
std::optional<Command> command_of(const Word& word);

/// M50, M60, M70, M80 and M90: the line is an offset line.
bool is_offset(Command command);
/// G1 to G3 and G45 to G50.
bool is_routing(Command command);
/// Nothing may follow it in its line.
bool is_camera(Command command);

/// One program line. Its argument is the text behind a last word that takes one (M97,text), blanks
/// at its ends removed.
using Block = WordBlock<32>;

/// Splits a line into words. A word is a letter A to Z and characters of `+-.0123456789`; blanks
/// between words are skipped, a comment in brackets ends the line. M47, M49, M75, M76, M97, M98,
/// M99, G35 and G39 take what follows as text.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, A.3 Structure of a program line
/// See    tests/program/sieb_meyer/text/lexer_test.cc
std::optional<LexFault> lex(const SourceLine& line, Block& block);

/// Nothing but blanks and a comment.
bool is_blank(std::string_view line);
/// The line behind the slash of block delete; absent if it does not begin with one.
std::optional<SourceLine> without_slash(const SourceLine& line);

}  // namespace panelcal::sieb_meyer
