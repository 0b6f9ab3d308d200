// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/plain_text.h"

#include <string>
#include <utility>
#include <vector>

#include "calib/base/units.h"
#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

using Eigen::Vector2d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr CharacterSet k5x7 = CharacterSet::Dots5x7;

/// A text of characters only; a row of holes shows as '~'.
std::string expanded(std::string_view text,
                     const TextVariables& variables = {},
                     int step = 1,
                     CharacterSet set = k5x7) {
  const auto cells = expand_text(text, variables, step, set);
  if (!cells) return "fault: " + cells.error().what;
  std::string out;
  for (const TextCell& cell : *cells) {
    const char* const c = std::get_if<char>(&cell);
    out += c ? *c : '~';
  }
  return out;
}

/// Rows of holes as '#' and '.', with a blank between two.
std::string hole_rows(std::string_view text, const TextVariables& variables, CharacterSet set) {
  const auto cells = expand_text(text, variables, 1, set);
  if (!cells) return "fault: " + cells.error().what;
  std::string out;
  for (const TextCell& cell : *cells) {
    const auto* const row = std::get_if<HoleRow>(&cell);
    if (!row) return "a character";
    if (!out.empty()) out += ' ';
    for (int column = 0; column < columns(set); ++column) {
      out += (row->columns >> column & 1) != 0 ? '#' : '.';
    }
  }
  return out;
}

TextFault fault_of(std::string_view text,
                   const TextVariables& variables = {},
                   CharacterSet set = k5x7) {
  auto cells = expand_text(text, variables, 1, set);
  EXPECT_FALSE(cells.has_value()) << text;
  return cells ? TextFault{text.size() + 1, "", ""} : std::move(cells).error();
}

std::vector<Vector2d> layout_of(std::string_view text,
                                const TextVariables& variables = {},
                                CharacterSet set = k5x7) {
  auto cells = expand_text(text, variables, 1, set);
  EXPECT_TRUE(cells.has_value()) << text;
  if (!cells) return {};
  const TextLayout layout(std::move(*cells), set);
  std::vector<Vector2d> out;
  for (std::int64_t i = 0; i < layout.size(); ++i) out.push_back(layout[i]);
  return out;
}

/// Of the drilled text, from edge to edge, in tool diameters.
Vector2d extent_diameters(const std::vector<Vector2d>& holes) {
  Vector2d low = holes.at(0);
  Vector2d high = holes.at(0);
  for (const Vector2d& hole : holes) {
    low = low.cwiseMin(hole);
    high = high.cwiseMax(hole);
  }
  return kPitchDiameters * (high - low) + Vector2d::Ones();
}

TEST(ExpandText, ManualPatternLabels) {
  struct Label {
    int run;
    int pattern;
    const char* text;
  };
  for (const Label& label : {Label{1, 1, "A2341-1-1"},
                             Label{1, 2, "A2341-1-2"},
                             Label{1, 3, "A2341-1-3"},
                             Label{2, 1, "A2341-2-1"},
                             Label{2, 2, "A2341-2-2"},
                             Label{2, 3, "A2341-2-3"}}) {
    EXPECT_EQ(expanded("A2341-&N-&R", {.run = label.run}, label.pattern), label.text);
  }
}

TEST(ExpandText, ReplacesEveryVariable) {
  const TextVariables variables{.date = "21/11/2026",
                                .time = "08:05:30",
                                .file = "BOARD7",
                                .extension = "DRL",
                                .module = "3",
                                .spindle = 4,
                                .breakage_counter = 12,
                                .run = 25,
                                .operator_text = "LOT 9"};
  EXPECT_EQ(expanded("&D &T", variables), "21/11/2026 08:05:30");
  EXPECT_EQ(expanded("&F.&E", variables), "BOARD7.DRL");
  EXPECT_EQ(expanded("&M/&S/&B/&N/&R", variables, 6), "3/4/12/25/6");
  EXPECT_EQ(expanded("(*)", variables), "(LOT 9)");
  EXPECT_EQ(expanded("X&PY&VZ", variables), "X~Y~Z");
  EXPECT_EQ(expanded("**", variables), "LOT 9LOT 9");
  EXPECT_EQ(expanded("", variables), "");
}

TEST(ExpandText, DrillsSmallLettersOfValuesAsCapitals) {
  EXPECT_EQ(expanded("&F.&E*", {.file = "board_7a", .extension = "drl", .operator_text = "jo"}),
            "BOARD_7A.DRLJO");
}

TEST(ExpandText, ValuesAreLiteral) {
  EXPECT_EQ(expanded("*&M", {.module = "*&N", .operator_text = "*&D&"}), "*&D&*&N");
}

TEST(ExpandText, WithoutValueTheGapClosesUp) {
  EXPECT_EQ(expanded("A*B&FC"), "ABC");
}

TEST(ExpandText, AnAmpersandWithoutLetterIsItself) {
  EXPECT_EQ(expanded("R&"), "R&");
  EXPECT_EQ(expanded("&4& &-"), "&4& &-");
  EXPECT_EQ(expanded("&&N", {.run = 8}), "&8");
  EXPECT_EQ(fault_of("AB&", {}, CharacterSet::Dots4x6).index, 2U);
}

TEST(ExpandText, KeepsCommasAndSpaces) {
  EXPECT_EQ(expanded("A, B"), "A, B");
}

TEST(ExpandText, NamesThePlaceOfAnUnknownVariable) {
  for (const std::string text : {"AB&A", "AB&Z1", "AB&d", "AB&n"}) {
    const TextFault fault = fault_of(text);
    EXPECT_EQ(fault.index, 2U) << text;
    EXPECT_THAT(fault.what, HasSubstr('"' + text.substr(2, 2) + '"'));
    EXPECT_THAT(fault.expected, HasSubstr("&D &T &F &E &M &P &S &B &N &R &V"));
  }
}

TEST(ExpandText, NamesThePlaceOfASmallLetter) {
  const TextFault fault = fault_of("&N-Lot", {.run = 100});
  EXPECT_EQ(fault.index, 4U);
  EXPECT_THAT(fault.what, HasSubstr("\"o\""));
}

TEST(ExpandText, NamesThePlaceOfACharacterThatTheSetLacks) {
  for (const char c : std::string("|{~`\t\n\x7f\x80\xff")) {
    EXPECT_EQ(fault_of(std::string("AB") + c + "D").index, 2U) << static_cast<int>(c);
  }
  EXPECT_EQ(fault_of(std::string("AB\0", 3)).index, 2U);
  const TextFault minus = fault_of("A2341-&N", {}, CharacterSet::Dots3x5);
  EXPECT_EQ(minus.index, 5U);
  EXPECT_THAT(minus.what, AllOf(HasSubstr("\"-\""), HasSubstr("3x5")));
  EXPECT_THAT(minus.expected, Not(HasSubstr("-")));
  EXPECT_THAT(fault_of("A+", {}, CharacterSet::Hitachi).expected, HasSubstr(" -"));
  EXPECT_EQ(expanded("A-1 B", {}, 1, CharacterSet::Hitachi), "A-1 B");
}

TEST(ExpandText, NamesTheVariableWhoseValueTheSetLacks) {
  const TextFault date = fault_of("ON &D", {.date = "21/11/2026"}, CharacterSet::Dots3x5);
  EXPECT_EQ(date.index, 3U);
  EXPECT_THAT(date.what,
              AllOf(HasSubstr("\"/\""), HasSubstr("\"&D\""), HasSubstr("\"21/11/2026\"")));
  EXPECT_EQ(fault_of("&N*", {.operator_text = "A|"}).index, 2U);
  // The star of a value is a character like others, which only 5x7 has.
  EXPECT_EQ(fault_of("A*", {.operator_text = "*"}, CharacterSet::Dots4x6).index, 1U);
}

TEST(ExpandText, DrillsAsManyHolesAsTheSpindlesNumber) {
  EXPECT_EQ(hole_rows("&P", {.spindle = 1}, k5x7), "#....");
  EXPECT_EQ(hole_rows("&P", {.spindle = 2}, k5x7), "##...");
  EXPECT_EQ(hole_rows("&P", {.spindle = 5}, k5x7), "#####");
  EXPECT_EQ(hole_rows("&P", {.spindle = 6}, k5x7), "##### #....");
  EXPECT_EQ(hole_rows("&P", {.spindle = 7}, CharacterSet::Dots3x5), "### ### #..");
  for (int spindle = 1; spindle <= kMaxSpindle; ++spindle) {
    EXPECT_EQ(layout_of("&P", {.spindle = spindle}).size(), static_cast<std::size_t>(spindle));
  }
}

TEST(ExpandText, RefusesASpindleThatIsNone) {
  for (const int spindle : {-2147483647, -1, 0, kMaxSpindle + 1, 2147483647}) {
    const TextFault fault = fault_of("A&P", {.spindle = spindle});
    EXPECT_EQ(fault.index, 1U);
    EXPECT_THAT(fault.what, HasSubstr(std::to_string(spindle)));
    EXPECT_THAT(fault.expected, HasSubstr("1 to 64"));
  }
}

TEST(ExpandText, DrillsTheRunNumberInBinary) {
  EXPECT_EQ(hole_rows("&V", {.run = 1}, k5x7), "....#");
  EXPECT_EQ(hole_rows("&V", {.run = 2}, k5x7), "...#.");
  EXPECT_EQ(hole_rows("&V", {.run = 6}, k5x7), "..##.");
  EXPECT_EQ(hole_rows("&V", {.run = 31}, k5x7), "#####");
  EXPECT_EQ(hole_rows("&V", {.run = 32}, k5x7), "....# .....");
  EXPECT_EQ(hole_rows("&V", {.run = 0}, k5x7), ".....");
  EXPECT_EQ(hole_rows("&V", {.run = 9}, CharacterSet::Dots3x5), "..# ..#");
  EXPECT_EQ(hole_rows("&V", {.run = 9}, CharacterSet::Excellon4x7), "#..#");
  EXPECT_EQ(hole_rows("&V", {.run = 2147483647}, CharacterSet::Dots4x6),
            ".### #### #### #### #### #### #### ####");
  const TextFault negative = fault_of("-&V", {.run = -1});
  EXPECT_EQ(negative.index, 1U);
  EXPECT_THAT(negative.what, HasSubstr("-1"));
}

TEST(TextLayout, ManualCharacterSize) {
  // "height of the character = 8.2 x", "character width = 5.8 x diameter of the drill bit".
  for (const char* const full : {"E", "H", "Z"}) {
    const Vector2d size = extent_diameters(layout_of(full));
    EXPECT_DOUBLE_EQ(size.x(), 5.8) << full;
    EXPECT_DOUBLE_EQ(size.y(), 8.2) << full;
  }
}

TEST(TextLayout, ManualToolDiameters) {
  // "CNC" 8.2 mm high takes T4 of 1.00 mm, 16.4 mm high T5 of 2.00 mm.
  const double height_diameters = extent_diameters(layout_of("CNC")).y();
  EXPECT_DOUBLE_EQ((mm(8.2) / height_diameters).in_mm(), 1);
  EXPECT_DOUBLE_EQ((mm(16.4) / height_diameters).in_mm(), 2);
}

TEST(TextLayout, LeavesOneColumnFreeBetweenCharacters) {
  // Three characters of 5 columns with a free one between two: 17 places, 16 pitches.
  EXPECT_DOUBLE_EQ(extent_diameters(layout_of("HHH")).x(), 16 * 1.2 + 1);
  EXPECT_DOUBLE_EQ(extent_diameters(layout_of("HHH", {}, CharacterSet::Dots3x5)).x(), 10 * 1.2 + 1);
  EXPECT_DOUBLE_EQ(extent_diameters(layout_of("H H")).x(), 16 * 1.2 + 1);
}

TEST(TextLayout, BeginsAtTheReferencePointAndGoesUpAndDown) {
  const std::vector<Vector2d> holes = layout_of("L 1");
  const std::vector<Vector2d> l = {
      {0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}, {0, 6}, {1, 0}, {2, 0}, {3, 0}, {4, 0}};
  ASSERT_GT(holes.size(), l.size());
  for (std::size_t i = 0; i < l.size(); ++i) EXPECT_EQ(holes[i], l[i]) << i;
  // The 1 stands in the third place, 12 pitches on; its foot is in its columns 1 to 3.
  const std::vector<Vector2d> one = {
      {13, 5}, {13, 0}, {14, 0}, {14, 1}, {14, 2}, {14, 3}, {14, 4}, {14, 5}, {14, 6}, {15, 0}};
  ASSERT_EQ(holes.size(), l.size() + one.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(holes[l.size() + i], one[i]) << i;
}

TEST(TextLayout, RowsOfHolesStandOnTheLowestGridRow) {
  const std::vector<Vector2d> spindle = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {6, 0}};
  EXPECT_EQ(layout_of("&P", {.spindle = 6}), spindle);
  const std::vector<Vector2d> run = {{8, 0}, {10, 0}};
  EXPECT_EQ(layout_of(" &V", {.run = 5}), run);
}

TEST(TextLayout, OfNothingHasNoHoles) {
  EXPECT_TRUE(layout_of("").empty());
  EXPECT_TRUE(layout_of("  ").empty());
  EXPECT_EQ(TextLayout({'a', HoleRow{}}, k5x7).size(), 0);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
