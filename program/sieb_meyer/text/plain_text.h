// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "program/geometry/dot_font.h"
#include "program/walk/control_settings.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// A row of holes on a character's lowest grid row, in place of a character.
struct HoleRow {
  std::uint8_t columns = 0;  ///< bit i: a hole in column i

  friend bool operator==(const HoleRow&, const HoleRow&) = default;
};

/// One place of a text: a character of the set, or a row of holes.
using TextCell = std::variant<char, HoleRow>;

/// The reason why a text cannot be drilled.
struct TextFault {
  std::size_t index = 0;  ///< in the text as programmed; the variable's, if its value is at fault
  std::string what;       ///< names the offending text, in quotes
  std::string expected;
};

/// A text as it is to be drilled: its variables replaced by their values, all else literally.
///
/// A value is literal too: it may say '*' and '&', which 5x7 has. '*' without a value is nothing.
/// '&' is itself where no letter follows. &P and &V take as many whole characters as they need, of
/// as many holes as the set has columns:
///
///   &P   as many holes as the spindle's number says, from the left
///   &V   the run number in binary, a hole for 1, most significant first, so that the last column
///        of the last character is worth 1; one character at least
///
/// The manual wants a set of fixed character width for variables with '&'. Those here all are.
///
/// In     step_number: of the pattern's copy, from 1 (&R)
/// Fails  a character that the set lacks, a small letter, an unknown variable; &P of a spindle
///        outside 1 to kMaxSpindle; &V of a negative run
/// Cost   O(n), n being the length of the result
/// Source SIEB & MEYER manual, M97, Text variables and Character repertoire; ISO code
/// See    tests/program/sieb_meyer/text/plain_text_test.cc
tl::expected<std::vector<TextCell>, TextFault> expand_text(std::string_view text,
                                                           const TextVariables& variables,
                                                           int step_number,
                                                           CharacterSet set);

/// The holes of a text in drilling order, worked out one at a time: (column, row) in pitches from
/// the text's reference point, columns in the direction of writing, rows upwards as one reads.
///
/// A pitch is kPitchDiameters tool diameters.
///
/// Source SIEB & MEYER manual, M97, Character matrix
/// See    tests/program/sieb_meyer/text/plain_text_test.cc
class TextLayout {
 public:
  /// cells: of expand_text with the same set. A character that the set lacks has no holes.
  TextLayout(std::vector<TextCell> cells, CharacterSet set);

  std::int64_t size() const { return n_holes_to_.empty() ? 0 : n_holes_to_.back(); }
  /// Precondition: 0 <= i < size(). Cost: O(log n), n being the number of cells.
  Eigen::Vector2d operator[](std::int64_t i) const;

 private:
  std::vector<TextCell> cells_;
  CharacterSet set_;
  std::vector<std::int64_t> n_holes_to_;  // the end of each cell
};

}  // namespace panelcal::sieb_meyer
