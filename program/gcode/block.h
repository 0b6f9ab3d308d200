// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "program/text/source_text.h"

namespace panelcal::gcode {

/// A letter and its number: `X-12.5`.
struct GcodeWord {
  char letter = 'G';  ///< upper case; # of an assignment: `#1=5`
  double value = 0;
  std::size_t begin = 0;  ///< of its text in the line
  std::size_t end = 0;
  /// A variable or an expression has the value, which is unknown before the program is executed.
  bool is_computed = false;

  bool is(char a_letter, double a_value) const {
    return !is_computed && letter == a_letter && value == a_value;
  }
};

/// A line of G-code.
struct GcodeBlock {
  std::string_view text;
  int line = 0;
  std::vector<GcodeWord> words;
  /// Comments, percent signs and blanks: what is left when the words are taken out.
  std::string rest;
  bool is_deleted =
      false;  ///< begins with a slash: whether it is executed is the operator's choice

  const GcodeWord* find(char letter) const;
  bool has(char letter) const { return find(letter) != nullptr; }
};

/// Reads one line: words in any order, blanks anywhere, comments in brackets or behind a semicolon.
/// Variables and expressions are not evaluated: a word of one is computed.
///
/// Fails  not-supported: words of O, and assignments to the control's own variables (above 5000)
///        or to one whose number is computed; number-malformed; command-unknown: a character that
///        begins nothing; argument-invalid: a letter but G and M twice in a line
/// Source NIST RS274NGC version 3 (2000), 3.3
/// See    tests/program/gcode/block_test.cc
Expected<GcodeBlock> read_gcode_block(const SourceLine& line, const std::string& file);

}  // namespace panelcal::gcode
