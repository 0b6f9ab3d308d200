// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace panelcal {

/// The sets of characters that controls drill hole by hole. In each all characters are equally
/// wide.
///
/// The manuals name the characters of each set and its grid, not the shapes: those are panelcal's
/// own. They say nothing of Hitachi's grid; here it is that of Dots5x7, with the same shapes.
///
/// Source CNC-7 manual, Canned Text; SIEB & MEYER manual, M97, Character repertoire
/// See    docs/font.md shows them all; tests/program/geometry/dot_font_test.cc
enum class CharacterSet : std::uint8_t {
  Dots3x5,      ///< A-Z 0-9
  Dots4x6,      ///< A-Z 0-9 + - / . , ! ? : ( ) "
  Dots5x7,      ///< every character of ASCII from the space to the underscore
  Excellon4x7,  ///< A-Z 0-9 + - /
  Hitachi,      ///< A-Z 0-9 -
};

/// As configurations say it: 3x5, 4x6, 5x7, excellon, hitachi.
std::string_view name(CharacterSet set);
std::optional<CharacterSet> character_set_from_name(std::string_view name);

int columns(CharacterSet set);
int rows(CharacterSet set);
/// From a character to the next, in pitches: its columns and one that stays free.
inline int advance_columns(CharacterSet set) {
  return columns(set) + 1;
}
/// The set's characters besides the space, the letters A to Z and the digits.
std::string_view signs(CharacterSet set);

/// Between neighbouring places of the grid, in tool diameters, whatever the set.
///
/// Source CNC-7 manual, Canned Text; SIEB & MEYER manual, M98, Character matrix
inline constexpr double kPitchDiameters = 1.2;

/// A hole of a character, counted in pitches from the lower left place of its grid.
///
/// That place is the text's reference point for the first character. SIEB & MEYER calls it GP(1,7),
/// which makes rows count from the top.
struct GlyphHole {
  std::int8_t column = 0;  ///< in the direction of writing
  std::int8_t row = 0;     ///< upwards, as one reads

  friend bool operator==(const GlyphHole&, const GlyphHole&) = default;
};

/// The holes of a character in drilling order: column by column, up and down in turn.
class Glyph {
 public:
  static constexpr std::size_t kMaxHoles = std::size_t{5} * 7;

  std::span<const GlyphHole> holes() const { return {holes_.data(), n_holes_}; }
  /// Precondition: fewer than kMaxHoles holes so far.
  void add(GlyphHole hole) { holes_[n_holes_++] = hole; }

 private:
  std::array<GlyphHole, kMaxHoles> holes_{};
  std::size_t n_holes_ = 0;
};

/// A character of a set, none if the set lacks it. The space, which every set has, has no holes.
std::optional<Glyph> glyph(CharacterSet set, char c);

}  // namespace panelcal
