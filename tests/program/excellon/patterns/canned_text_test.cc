// SPDX-License-Identifier: Apache-2.0
// Canned texts: CNC-7 manual, Canned Text, Canned Text Offset. Where the manual names no order,
// places are compared without one.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/excellon/patterns/cycle_run.h"
#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::clean_holes;
using test::diagnostics_of;
using test::expect_same_places;
using test::holes_of;
using test::inch_leading_zeros;
using test::IsNearMatrix;
using test::joined;
using test::Places;
using test::says;
using test::shifted;
using testing::Contains;

// --- CNC-7 manual: Canned Text -------------------------------------------------------------------

constexpr double kPitch_inch = 1.2 * 0.04;  // for the 0.04 inch of T1
const Vector2d kStart(1, 2);

Places text_holes(const std::string& text, const std::string& operator_id = "") {
  ReadOptions reading;
  reading.operator_id = operator_id;
  return clean_holes(inch_leading_zeros("T1\n" + text + "\nX01Y02\nM30\n"), reading);
}

/// Columns and rows of the grid, counted from where the text starts.
using Cells = std::set<std::pair<int, int>>;

Cells cells(const Places& holes) {
  Cells out;
  for (const Vector2d& hole : holes) {
    const Vector2d at = (hole - kStart) / kPitch_inch;
    const Vector2d whole(std::round(at.x()), std::round(at.y()));
    EXPECT_THAT(at, IsNearMatrix(whole, 1e-6)) << "off the grid";
    const bool is_new =
        out.emplace(static_cast<int>(whole.x()), static_cast<int>(whole.y())).second;
    EXPECT_TRUE(is_new) << "drilled twice";
  }
  return out;
}

Cells shifted_right(const Cells& from, int columns) {
  Cells out;
  for (const auto& [x, y] : from) out.emplace(x + columns, y);
  return out;
}

Cells both(Cells first, const Cells& second) {
  first.insert(second.begin(), second.end());
  return first;
}

struct Extent {
  int width, height;
};

Extent extent(const Cells& of) {
  int x_min = 1000, x_max = -1000, y_min = 1000, y_max = -1000;
  for (const auto& [x, y] : of) {
    x_min = std::min(x_min, x);
    x_max = std::max(x_max, x);
    y_min = std::min(y_min, y);
    y_max = std::max(y_max, y);
  }
  return {x_max - x_min + 1, y_max - y_min + 1};
}

TEST(CannedText, EveryCharacterIsItsOwnPatternOfFourBySeven) {
  std::set<Cells> known;
  for (const char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-/")) {
    const Cells one = cells(text_holes(std::string("M97,") + c));
    EXPECT_FALSE(one.empty()) << c;
    EXPECT_LE(extent(one).width, 4) << c;
    EXPECT_LE(extent(one).height, 7) << c;
    EXPECT_TRUE(known.insert(one).second) << c << " looks like another character";
  }
}

TEST(CannedText, LettersFillTheGrid) {
  const Extent e = extent(cells(text_holes("M97,E")));
  EXPECT_EQ(e.width, 4);
  EXPECT_EQ(e.height, 7);
}

/// From one character to the next, in columns.
int advance() {
  const Cells one = cells(text_holes("M97,E"));
  const Cells two = cells(text_holes("M97,EE"));
  for (int columns = 4; columns <= 8; ++columns) {
    if (two == both(one, shifted_right(one, columns))) return columns;
  }
  ADD_FAILURE() << "the second character is not a shifted first one";
  return 0;
}

TEST(CannedText, CharactersFollowAlongX) {
  EXPECT_GE(advance(), 5);  // or they would touch
}

TEST(CannedText, CommasAreSpaces) {
  const Cells one = cells(text_holes("M97,E"));
  EXPECT_EQ(cells(text_holes("M97,E,E")), both(one, shifted_right(one, 2 * advance())));
}

TEST(CannedText, M98IsM97TurnedAboutItsStart) {
  Places turned;
  for (const Vector2d& hole : text_holes("M97,DEMO,7")) {
    const Vector2d from_start = hole - kStart;
    turned.emplace_back(kStart + Vector2d(-from_start.y(), from_start.x()));
  }
  expect_same_places(text_holes("M98,DEMO,7"), turned);
}

TEST(CannedText, WithoutADiameterLettersAreAQuarterInchHigh) {
  const Places holes = clean_holes("M48\nINCH,LZ\nT5F2\n%\nT5\nM97,E\nX01Y02\nM30\n");
  double lowest = 100;
  double highest = -100;
  for (const Vector2d& hole : holes) {
    lowest = std::min(lowest, hole.y());
    highest = std::max(highest, hole.y());
  }
  EXPECT_NEAR(highest - lowest, 6 * 0.0417, 5e-4);  // 0.25 and 6 x 0.0417 are not quite the same
}

TEST(CannedText, AnAsteriskIsTheOperatorsName) {
  EXPECT_EQ(cells(text_holes("M97,A*B", "OP1")), cells(text_holes("M97,AOP1B")));
  EXPECT_EQ(cells(text_holes("M97,*", "OP1")), cells(text_holes("M97,OP1")));
}

TEST(CannedText, WithoutAnOperatorTheGapOfTheAsteriskIsClosed) {
  EXPECT_EQ(cells(text_holes("M97,A*B")), cells(text_holes("M97,AB")));
}

TEST(CannedText, CharactersThatItDoesNotHaveAreAnError) {
  for (const char* text : {"M97,A?B", "M97,demo", "M98,A_B", "M97,A.B"}) {
    EXPECT_THAT(diagnostics_of(text + std::string("\nX01Y02\n")),
                Contains(says(7, "error[argument-invalid]")))
        << text;
  }
}

// --- CNC-7 manual: Canned Text Offset ------------------------------------------------------------

TEST(CannedTextOffset, InTheHeaderShiftsEveryText) {
  const std::string header = "M48\nINCH,LZ\nCAN_TEXT_OFF,.5,.25\nT1C.04\n%\nT1\n";
  for (const char* text : {"M97,AB", "M98,AB"}) {
    expect_same_places(clean_holes(header + text + "\nX01Y02\nM30\n"),
                       shifted(text_holes(text), {0.5, 0.25}));
  }
}

TEST(CannedTextOffset, InTheBodyShiftsTheTextsThatFollow) {
  const Places plain = text_holes("M97,AB");
  expect_same_places(holes_of("M97,AB\nX01Y02\nCAN_TEXT_OFF,.5,.25\nM97,AB\nX01Y02\n"),
                     joined(plain, shifted(plain, {0.5, 0.25})));
}

TEST(CannedTextOffset, OneParameterChangesXAlone) {
  expect_same_places(holes_of("CAN_TEXT_OFF,.5,.25\nCAN_TEXT_OFF,.75\nM97,AB\nX01Y02\n"),
                     shifted(text_holes("M97,AB"), {0.75, 0.25}));
}

TEST(CannedTextOffset, AloneChangesNothing) {
  expect_same_places(holes_of("CAN_TEXT_OFF,.5,.25\nCAN_TEXT_OFF\nM97,AB\nX01Y02\n"),
                     shifted(text_holes("M97,AB"), {0.5, 0.25}));
}

TEST(CannedTextOffset, ShiftsNothingButTexts) {
  expect_same_places(holes_of("CAN_TEXT_OFF,.5,.25\nX01Y01\n"), {{1, 1}});
}

}  // namespace
}  // namespace panelcal
