// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/text_engraving.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

const std::string kCharacters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-/";

using HoleSet = std::set<std::pair<int, int>>;

HoleSet holes_of(char c) {
  const std::optional<Glyph> found = glyph(c);
  HoleSet out;
  if (!found) {
    ADD_FAILURE() << "no glyph for " << c;
    return out;
  }
  for (const GlyphHole& hole : found->holes()) out.emplace(hole.column, hole.row);
  EXPECT_EQ(out.size(), found->holes().size()) << "a hole of " << c << " comes twice";
  return out;
}

/// Characters side by side as the docs show them, from the top row down.
std::string picture(const std::string& text) {
  std::string out;
  for (int row = kGlyphRows - 1; row >= 0; --row) {
    std::string line;
    for (const char c : text) {
      const HoleSet holes = holes_of(c);
      if (!line.empty()) line += "   ";
      for (int column = 0; column < kGlyphColumns; ++column) {
        line += holes.contains({column, row}) ? '#' : '.';
      }
    }
    out += line + "\n";
  }
  return out;
}

TEST(Glyph, AnAIsAnA) {
  EXPECT_EQ(picture("A1-"),
            ".##.   ..#.   ....\n"
            "#..#   .##.   ....\n"
            "#..#   #.#.   ....\n"
            "####   ..#.   ###.\n"
            "#..#   ..#.   ....\n"
            "#..#   ..#.   ....\n"
            "#..#   ..#.   ....\n");
}

TEST(Glyph, EveryCharacterOfTheManualHasOne) {
  for (const char c : kCharacters) {
    const HoleSet holes = holes_of(c);
    EXPECT_FALSE(holes.empty()) << c;
    for (const auto& [column, row] : holes) {
      EXPECT_TRUE(column >= 0 && column < kGlyphColumns && row >= 0 && row < kGlyphRows) << c;
    }
  }
  ASSERT_TRUE(glyph(' ').has_value());
  EXPECT_TRUE(glyph(' ')->holes().empty());
}

TEST(Glyph, OthersHaveNone) {
  for (int c = 0; c < 256; ++c) {
    const char character = static_cast<char>(c);
    const bool is_known = c == ' ' || kCharacters.find(character) != std::string::npos;
    EXPECT_EQ(glyph(character).has_value(), is_known) << c;
  }
}

TEST(Glyph, NoMissingHoleMakesAnotherCharacter) {
  for (const char a : kCharacters) {
    for (const char b : kCharacters) {
      if (a >= b) continue;
      HoleSet differences;
      std::ranges::set_symmetric_difference(
          holes_of(a), holes_of(b), std::inserter(differences, differences.end()));
      EXPECT_GE(differences.size(), 2U) << a << " and " << b;
    }
  }
}

TEST(Glyph, LettersAndDigitsAreAsHighAsTheGrid) {
  for (const char c : kCharacters.substr(0, 36)) {
    const HoleSet holes = holes_of(c);
    for (const int row : {0, kGlyphRows - 1}) {
      EXPECT_TRUE(std::ranges::any_of(holes, [row](const auto& hole) {
        return hole.second == row;
      })) << c;
    }
  }
}

TEST(Glyph, IsDrilledColumnByColumnUpAndDown) {
  const std::optional<Glyph> l = glyph('L');
  ASSERT_TRUE(l.has_value());
  const std::vector<GlyphHole> expected = {
      {0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}, {0, 6}, {1, 0}, {2, 0}, {3, 0}};
  EXPECT_TRUE(std::ranges::equal(l->holes(), expected));
  const std::optional<Glyph> plus = glyph('+');
  ASSERT_TRUE(plus.has_value());
  const std::vector<GlyphHole> down = {{0, 3}, {1, 4}, {1, 3}, {1, 2}, {2, 3}};
  EXPECT_TRUE(std::ranges::equal(plus->holes(), down));
}

TEST(Glyph, NeighboursDoNotTouch) {
  // The last column of one and the first of the next are two pitches apart, 2.4 diameters.
  EXPECT_EQ(kAdvanceColumns - (kGlyphColumns - 1), 2);
}

TEST(TextPitch, ManualSpacing) {
  EXPECT_DOUBLE_EQ(text_pitch_mm(inch(0.032)), inch(0.0384).in_mm());
  EXPECT_DOUBLE_EQ(text_pitch_mm(mm(1)), 1.2);
  EXPECT_DOUBLE_EQ(text_pitch_mm(std::nullopt), inch(0.0417).in_mm());
  EXPECT_DOUBLE_EQ(text_pitch_mm(mm(0)), inch(0.0417).in_mm());
  // Letters of a quarter inch.
  EXPECT_NEAR(text_pitch_mm(std::nullopt) * (kGlyphRows - 1), inch(0.25).in_mm(), 0.01);
}

TEST(PrepareText, ManualSampleProgram) {
  EXPECT_EQ(prepare_text("COMPLEX,PART,PROGRAM", ""), "COMPLEX PART PROGRAM");
  EXPECT_EQ(prepare_text("DEMONSTRATION,PANEL", ""), "DEMONSTRATION PANEL");
  EXPECT_EQ(prepare_text("EXCELLON,AUTOMATION", ""), "EXCELLON AUTOMATION");
}

TEST(PrepareText, AnAsteriskIsTheOperatorsText) {
  EXPECT_EQ(prepare_text("LOT,*-1", "JS/7,A"), "LOT JS/7 A-1");
  EXPECT_EQ(prepare_text("*", "B"), "B");
  EXPECT_EQ(prepare_text("*+*", "42"), "42+42");
}

TEST(PrepareText, WithoutOperatorTheGapClosesUp) {
  EXPECT_EQ(prepare_text("LOT,*7", ""), "LOT 7");
  EXPECT_EQ(prepare_text("*", ""), "");
  EXPECT_EQ(prepare_text("", "X"), "");
}

TEST(PrepareText, SpacesAreSpaces) {
  EXPECT_EQ(prepare_text("A B", ""), "A B");
}

TEST(PrepareText, NamesThePlaceOfACharacterThatTheMachineDoesNotKnow) {
  for (const char c : std::string("abc.:_#\t\x80")) {
    const auto prepared = prepare_text(std::string("AB,") + c + "D", "");
    ASSERT_FALSE(prepared.has_value()) << c;
    EXPECT_EQ(prepared.error(), 3U);
  }
  // In the operator's text: the place of the asterisk; an asterisk there has no meaning.
  EXPECT_EQ(prepare_text("AB*", "ok").error(), 2U);
  EXPECT_EQ(prepare_text("AB*", "*").error(), 2U);
}

TEST(FontPage, ShowsEveryGlyphAsItIs) {
  const std::ifstream file(PANELCAL_SOURCE_DIR "/docs/font.md");
  std::ostringstream page;
  page << file.rdbuf();
  for (std::size_t i = 0; i < kCharacters.size(); i += 10) {
    const std::string text = kCharacters.substr(i, 10);
    std::string block;
    for (const char c : text)
      block += block.empty() ? std::string(1, c) : std::string("      ") + c;
    EXPECT_THAT(page.str(), testing::HasSubstr("```\n" + block + "\n\n" + picture(text) + "```\n"));
  }
}

}  // namespace
}  // namespace panelcal::excellon
