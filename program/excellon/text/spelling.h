// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/text/source_text.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// A program's text in the manual's characters.
struct Spelling {
  std::string text;            ///< empty: there is nothing to change
  bool calls_patterns = true;  ///< false: it has no M99
};

/// Writes a program's text with the manual's characters where it is written with others that have
/// one reading only: small letters, block numbers (`N10`), comments in brackets or behind a block
/// (`X1Y1 ;drill`), NUL characters before and behind the program.
///
/// Every character stays in its place or becomes a blank, so that lines and columns are those of
/// the source. Texts for people and files (M45, M47, M97 to M99), lines that begin with $ and
/// comment lines stay as they are.
///
/// In     reporter: notation-accepted, once for each kind
/// Fails  argument-invalid: a comment behind a block that states the number format
/// Cost   one look at each character, 16 at a time, where there is nothing to change
/// See    tests/program/excellon/text/spelling_test.cc
Spelling respell(std::string_view bytes, const Reporter& reporter);

/// The line that shows that a text is of another kind.
struct ForeignText {
  int line = 0;           ///< 0: the text may be a program, and its lines are judged one by one
  std::string_view text;  ///< of the line, without blanks at either end
};

/// Finds texts that are no program of this language, such as a board, a picture, or a program of
/// the other language with one % too few: their first line begins with % and goes on, and no M48
/// follows, or none of their first 200 lines is a block.
ForeignText find_foreign(std::string_view bytes);

}  // namespace panelcal::excellon
