// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/dot_font.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/folders.h"

namespace panelcal {
namespace {

const std::string kLettersAndDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";

/// A set as the manuals' tables and grids have it, apart from the code's own table.
struct ManualSet {
  CharacterSet set;
  std::string name;
  int columns;
  int rows;
  std::string signs;
  std::string heading;  // in docs/font.md

  std::string characters() const { return kLettersAndDigits + signs; }
};

const std::array kSets = {
    ManualSet{CharacterSet::Dots3x5, "3x5", 3, 5, "", "## 3x5"},
    ManualSet{CharacterSet::Dots4x6, "4x6", 4, 6, "+-/.,!?:()\"", "## 4x6"},
    ManualSet{
        CharacterSet::Dots5x7, "5x7", 5, 7, "+-/.,!?:()\"#$%&'*;<=>@[\\]^_", "## 5x7 and hitachi"},
    ManualSet{CharacterSet::Excellon4x7, "excellon", 4, 7, "+-/", "## excellon"},
    ManualSet{CharacterSet::Hitachi, "hitachi", 5, 7, "-", "## 5x7 and hitachi"},
};

using HoleSet = std::set<std::pair<int, int>>;

HoleSet holes_of(CharacterSet set, char c) {
  const std::optional<Glyph> found = glyph(set, c);
  HoleSet out;
  if (!found) {
    ADD_FAILURE() << "no glyph for " << c << " in " << name(set);
    return out;
  }
  for (const GlyphHole& hole : found->holes()) out.emplace(hole.column, hole.row);
  EXPECT_EQ(out.size(), found->holes().size()) << "a hole of " << c << " comes twice";
  return out;
}

/// Characters side by side as the docs show them, from the top row down.
std::string picture(CharacterSet set, const std::string& text) {
  std::string out;
  for (int row = rows(set) - 1; row >= 0; --row) {
    std::string line;
    for (const char c : text) {
      const HoleSet holes = holes_of(set, c);
      if (!line.empty()) line += "   ";
      for (int column = 0; column < columns(set); ++column) {
        line += holes.contains({column, row}) ? '#' : '.';
      }
    }
    out += line + "\n";
  }
  return out;
}

TEST(CharacterSet, HasTheGridAndTheNameOfTheManual) {
  for (const ManualSet& manual : kSets) {
    EXPECT_EQ(name(manual.set), manual.name);
    EXPECT_EQ(character_set_from_name(manual.name), manual.set);
    EXPECT_EQ(columns(manual.set), manual.columns) << manual.name;
    EXPECT_EQ(rows(manual.set), manual.rows) << manual.name;
    // "5 drill holes plus the width of one drill hole as free space to the next character".
    EXPECT_EQ(advance_columns(manual.set), manual.columns + 1) << manual.name;
    EXPECT_EQ(signs(manual.set), manual.signs) << manual.name;
  }
  for (const char* const other : {"", "5X7", "5x8", "Excellon", "hitachi ", "3x"}) {
    EXPECT_FALSE(character_set_from_name(other).has_value()) << other;
  }
}

TEST(CharacterSet, TheLargestIsAsciiFromTheSpaceToTheUnderscore) {
  for (int c = 0; c < 256; ++c) {
    EXPECT_EQ(glyph(CharacterSet::Dots5x7, static_cast<char>(c)).has_value(), c >= ' ' && c <= '_')
        << c;
  }
}

TEST(Glyph, AnAIsAnA) {
  EXPECT_EQ(picture(CharacterSet::Excellon4x7, "A1-"),
            ".##.   ..#.   ....\n"
            "#..#   .##.   ....\n"
            "#..#   #.#.   ....\n"
            "####   ..#.   ###.\n"
            "#..#   ..#.   ....\n"
            "#..#   ..#.   ....\n"
            "#..#   ..#.   ....\n");
  EXPECT_EQ(picture(CharacterSet::Dots5x7, "A1-"),
            ".###.   ..#..   .....\n"
            "#...#   .##..   .....\n"
            "#...#   ..#..   .....\n"
            "#####   ..#..   #####\n"
            "#...#   ..#..   .....\n"
            "#...#   ..#..   .....\n"
            "#...#   .###.   .....\n");
}

TEST(Glyph, EveryCharacterOfTheManualHasOneAndOthersHaveNone) {
  for (const ManualSet& manual : kSets) {
    for (int i = 0; i < 256; ++i) {
      const char c = static_cast<char>(i);
      const bool is_known = c == ' ' || manual.characters().find(c) != std::string::npos;
      EXPECT_EQ(glyph(manual.set, c).has_value(), is_known) << i << " in " << manual.name;
    }
  }
}

TEST(Glyph, StandsOnItsGridAndHasHoles) {
  for (const ManualSet& manual : kSets) {
    for (const char c : manual.characters()) {
      const HoleSet holes = holes_of(manual.set, c);
      EXPECT_FALSE(holes.empty()) << c << " in " << manual.name;
      for (const auto& [column, row] : holes) {
        EXPECT_TRUE(column >= 0 && column < manual.columns) << c << " in " << manual.name;
        EXPECT_TRUE(row >= 0 && row < manual.rows) << c << " in " << manual.name;
      }
    }
    EXPECT_TRUE(holes_of(manual.set, ' ').empty()) << manual.name;
  }
}

TEST(Glyph, NoMissingHoleMakesAnotherCharacter) {
  for (const ManualSet& manual : kSets) {
    for (const char a : manual.characters()) {
      for (const char b : manual.characters()) {
        if (a >= b) continue;
        HoleSet differences;
        std::ranges::set_symmetric_difference(holes_of(manual.set, a),
                                              holes_of(manual.set, b),
                                              std::inserter(differences, differences.end()));
        EXPECT_GE(differences.size(), 2U) << a << " and " << b << " in " << manual.name;
      }
    }
  }
}

TEST(Glyph, LettersAndDigitsAreAsHighAsTheGrid) {
  for (const ManualSet& manual : kSets) {
    for (const char c : kLettersAndDigits) {
      const HoleSet holes = holes_of(manual.set, c);
      for (const int row : {0, manual.rows - 1}) {
        EXPECT_TRUE(
            std::ranges::any_of(holes, [row](const auto& hole) { return hole.second == row; }))
            << c << " in " << manual.name;
      }
    }
  }
}

TEST(Glyph, HitachiLooksLikeTheLargestSet) {
  for (const char c : kSets.back().characters()) {
    EXPECT_EQ(holes_of(CharacterSet::Hitachi, c), holes_of(CharacterSet::Dots5x7, c)) << c;
  }
}

TEST(Glyph, IsDrilledColumnByColumnUpAndDown) {
  const std::optional<Glyph> l = glyph(CharacterSet::Excellon4x7, 'L');
  ASSERT_TRUE(l.has_value());
  const std::vector<GlyphHole> expected = {
      {0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}, {0, 6}, {1, 0}, {2, 0}, {3, 0}};
  EXPECT_TRUE(std::ranges::equal(l->holes(), expected));
  const std::optional<Glyph> plus = glyph(CharacterSet::Excellon4x7, '+');
  ASSERT_TRUE(plus.has_value());
  const std::vector<GlyphHole> down = {{0, 3}, {1, 4}, {1, 3}, {1, 2}, {2, 3}};
  EXPECT_TRUE(std::ranges::equal(plus->holes(), down));
}

TEST(Glyph, OfEverySetIsDrilledColumnByColumnUpAndDown) {
  for (const ManualSet& manual : kSets) {
    for (const char c : manual.characters()) {
      const std::optional<Glyph> drilled = glyph(manual.set, c);
      ASSERT_TRUE(drilled.has_value()) << c;
      EXPECT_TRUE(std::ranges::is_sorted(
          drilled->holes(),
          {},
          [](const GlyphHole& hole) {
            return std::pair(hole.column, hole.column % 2 == 0 ? hole.row : -hole.row);
          }))
          << c << " in " << manual.name;
    }
  }
}

std::string font_page() {
  const std::ifstream file(test::source_folder() / "docs/font.md");
  std::ostringstream page;
  page << file.rdbuf();
  return page.str();
}

/// docs/font.md from a set's heading to the next heading.
std::string section_of_page(const std::string& heading) {
  const std::string text = "\n" + font_page();
  const std::size_t begin = text.find("\n" + heading + "\n");
  if (begin == std::string::npos) return "";
  const std::size_t end = text.find("\n## ", begin + 1);
  return text.substr(begin, end == std::string::npos ? end : end - begin);
}

TEST(FontPage, ListsEverySet) {
  for (const ManualSet& manual : kSets) {
    std::string row = "| `" + manual.name + "` | " + std::to_string(manual.columns) + " columns, " +
                      std::to_string(manual.rows) + " rows | ";
    for (std::size_t i = 0; i < manual.signs.size(); ++i) {
      row += std::string(i == 0 ? "`" : " ") + manual.signs[i];
    }
    row += manual.signs.empty() ? "none | " : "` | ";
    EXPECT_THAT(font_page(), testing::HasSubstr("\n" + row));
  }
}

TEST(FontPage, ShowsEveryGlyphAsItIs) {
  for (const ManualSet& manual : kSets) {
    // One picture serves both of these sets.
    if (manual.set == CharacterSet::Hitachi) continue;
    const std::string section = section_of_page(manual.heading);
    const std::string gap(static_cast<std::size_t>(manual.columns) + 2, ' ');
    for (std::size_t i = 0; i < manual.characters().size(); i += 10) {
      const std::string text = manual.characters().substr(i, 10);
      std::string names;
      for (const char c : text) names += names.empty() ? std::string(1, c) : gap + c;
      const std::string block = names + "\n\n" + picture(manual.set, text);
      EXPECT_THAT(section, testing::HasSubstr("```\n" + block + "```\n")) << manual.name;
    }
  }
}

}  // namespace
}  // namespace panelcal
