// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "panelcal/calib/base/units.h"

namespace panelcal::excellon {

inline constexpr int kGlyphColumns = 4;
inline constexpr int kGlyphRows = 7;
/// From a character to the next: 4 columns take 3 pitches, which leaves a gap of 2.
inline constexpr int kAdvanceColumns = 5;

/// A hole of a character, counted in pitches from its lower left corner.
struct GlyphHole {
  std::int8_t column = 0;  ///< in the direction of writing
  std::int8_t row = 0;     ///< upwards, as one reads

  friend bool operator==(const GlyphHole&, const GlyphHole&) = default;
};

/// The holes of a character in drilling order: column by column, up and down in turn.
class Glyph {
 public:
  std::span<const GlyphHole> holes() const { return {holes_.data(), n_holes_}; }
  void add(GlyphHole hole) { holes_[n_holes_++] = hole; }

 private:
  std::array<GlyphHole, static_cast<std::size_t>(kGlyphColumns) * kGlyphRows> holes_{};
  std::size_t n_holes_ = 0;
};

/// A character of panelcal's own font: A-Z, 0-9, + - / and the space, which has no holes.
///
/// Source CNC-7 manual, Canned Text (a 4x7 grid); semantics page, M97/M98 (the font is ours)
/// See    docs/font.md shows them all; tests/program/text_engraving_test.cc
std::optional<Glyph> glyph(char c);

/// Between the holes of a character: 1.2 tool diameters; 0.0417 inch, which makes letters of a
/// quarter inch, if the diameter is unknown (or zero, which is how programs say so).
///
/// Source CNC-7 manual, Canned Text
double text_pitch_mm(std::optional<Length> tool_diameter);

/// Text as it is to be drilled: commas become spaces, each '*' becomes the operator's text `opid`
/// or, if that is empty, nothing at all. The result has a glyph for each character.
///
/// A space is taken for a space too, though the manual writes it as a comma.
///
/// Fails  with the index in `text` of the first character that is not in the manual's set; the
///        index of the '*' if the character is in opid
/// Source CNC-7 manual, Canned Text
/// See    tests/program/text_engraving_test.cc
tl::expected<std::string, std::size_t> prepare_text(std::string_view text, std::string_view opid);

}  // namespace panelcal::excellon
