// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 2 (Drilling): nibbling, plain text, drilled patterns, peck and pulse
// drilling.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;
using test::expect_places;
using test::expect_same_places;
using test::hole_places;
using test::IsNearMatrix;
using test::joined;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::shifted;
using test::steps_of;
using testing::ElementsAre;

constexpr double kInch_mm = 25.4;
constexpr double kStandardGrid_mm = kInch_mm / 10;

// --- chapter 2.5, V1 -----------------------------------------------------------------------------

Places row(const Vector2d& first_mm, const Vector2d& step_mm, int n_holes) {
  Places places;
  for (int i = 0; i < n_holes; ++i) places.emplace_back(first_mm + i * step_mm);
  return places;
}

TEST(ManualV1, StandardGrid) {
  const ProgramRun run = run_5000("(STANDARD GRID)\nX30.00Y70.00 V1T1\nX45.24Y62.38\n");
  const Vector2d step(kStandardGrid_mm, 0);
  expect_same_places(hole_places(run), joined(row({30, 70}, step, 7), row({30, 62.38}, step, 7)));
  EXPECT_THAT(hole_places(run).front(), IsNearMatrix(Vector2d(30, 70), 1e-9));
}

/// "The diagonal corner point must be programmed with an accuracy of +-1.27 mm. Within this
/// deviation the CNC corrects position"; "the first programmed drill hole is used as reference".
TEST(ManualV1, StandardGridCorrectsTheCorner) {
  const ProgramRun run = run_5000("X30.00Y70.00 V1T1\nX46.24Y61.38\n");
  const Vector2d step(kStandardGrid_mm, 0);
  expect_same_places(hole_places(run), joined(row({30, 70}, step, 7), row({30, 62.38}, step, 7)));
}

TEST(ManualV1, FreelyDefinableGrid) {
  const ProgramRun run = run_5000("(VARIOUS GRID)\nX70.00Y30.00 V1T1\nX77.50Y45.00 W7\n");
  const Vector2d step(0, 2.5);
  expect_same_places(hole_places(run), joined(row({70, 30}, step, 7), row({77.5, 30}, step, 7)));
}

// --- chapter 2.5, V2 -----------------------------------------------------------------------------

/// The listing's `X37.94.` has a point too many.
TEST(ManualV2, TwelveHolesInX) {
  const ProgramRun run = run_5000("X10.Y10.V2T1\nX37.94Y10.W12\n");
  expect_places(hole_places(run), row({10, 10}, {kStandardGrid_mm, 0}, 12));
}

/// "The V2 command allows drilling a row of holes with any angle."
TEST(ManualV2, SlantingRow) {
  const ProgramRun run = run_5000("X10.Y10.V2T1\nX40.Y50.W6\nX90.Y90.\n");
  expect_places(hole_places(run), joined(row({10, 10}, {6, 8}, 6), {{90, 90}}));
}

// --- chapter 2.5, V3 -----------------------------------------------------------------------------

/// The holes of a rectangle's four sides, each once.
Places ring(const Vector2d& corner_mm, double pitch_mm, int n_x, int n_y) {
  Places places;
  for (int ix = 0; ix <= n_x; ++ix) {
    for (int iy = 0; iy <= n_y; ++iy) {
      const bool is_side = ix == 0 || ix == n_x || iy == 0 || iy == n_y;
      if (is_side) places.emplace_back(corner_mm + pitch_mm * Vector2d(ix, iy));
    }
  }
  return places;
}

/// 20 mm are corrected to 8 pitches.
TEST(ManualV3, SquareInTheStandardGrid) {
  const ProgramRun run = run_5000("X30.Y10.V3T1\nX50.Y30.\n");
  expect_same_places(hole_places(run), ring({30, 10}, kStandardGrid_mm, 8, 8));
}

/// 10 mm are corrected to 4 pitches, 30 mm to 12.
TEST(ManualV3, RectangleInTheStandardGrid) {
  const ProgramRun run = run_5000("X70.Y10.V3T1\nX80.Y40.\n");
  expect_same_places(hole_places(run), ring({70, 10}, kStandardGrid_mm, 4, 12));
}

/// The manual's second free grid, X70.Y50. to X80.Y90. with W9, gives 1.25 or 5 mm, not the 2.5 mm
/// that it states, and is left out.
TEST(ManualV3, SquareInTheFreelyDefinableGrid) {
  const ProgramRun run = run_5000("X30.Y50.V3T1\nX50.Y70.W9\n");
  expect_same_places(hole_places(run), ring({30, 50}, 2.5, 8, 8));
}

// --- chapter 2.5, V4 -----------------------------------------------------------------------------

Places circle(const Vector2d& center_mm, double radius_mm, int n_holes) {
  Places places;
  for (int i = 0; i < n_holes; ++i) {
    const double angle_rad = 2 * pi * i / n_holes;
    places.emplace_back(center_mm + radius_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad)));
  }
  return places;
}

TEST(ManualV4, CirclesOfTwelveAndSixtyHoles) {
  const ProgramRun run = run_5000("X50.Y50.V4T1\nX80.Y50.W12\nX50.Y50.V4T2\nX82.Y50.W60\n");
  const Places found = hole_places(run);
  ASSERT_EQ(found.size(), 72U);
  const Places inner(found.begin(), found.begin() + 12);
  const Places outer(found.begin() + 12, found.end());
  expect_same_places(inner, circle({50, 50}, 30, 12), 1e-6);
  expect_same_places(outer, circle({50, 50}, 32, 60), 1e-6);
  // "Any hole on the circular arc": the given one is among them, and the first.
  EXPECT_THAT(inner.front(), IsNearMatrix(Vector2d(80, 50), 1e-9));
  EXPECT_THAT(outer.front(), IsNearMatrix(Vector2d(82, 50), 1e-9));
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(run.holes()[i].drill.tool, i < 12 ? 1 : 2);
  }
  EXPECT_EQ(run.executed.tools().size(), 2U);
}

// --- chapter 2.3, G84 and G85 --------------------------------------------------------------------

/// "A hole with a diameter of 10.0 mm shall be nibbled." The edge is the tool's, so its centre
/// stays a tool radius inside.
TEST(ManualG84, NibblesACircleOfTenMillimeters) {
  const ProgramRun run = run_5000("X50.Y50.G84R5.T2\n");
  std::vector<double> angles_rad;
  for (const Vector2d& place : hole_places(run)) {
    const Vector2d out = place - Vector2d(50, 50);
    if (out.norm() < 4 - 1e-6) continue;  // the middle may be cleared first
    EXPECT_NEAR(out.norm(), 4, 1e-6);
    angles_rad.push_back(std::atan2(out.y(), out.x()));
  }
  ASSERT_GE(angles_rad.size(), 8U);
  std::ranges::sort(angles_rad);
  const double step_rad = 2 * pi / static_cast<double>(angles_rad.size());
  for (std::size_t i = 1; i < angles_rad.size(); ++i) {
    EXPECT_NEAR(angles_rad[i] - angles_rad[i - 1], step_rad, 1e-6) << "evenly spaced";
  }
  EXPECT_LT(step_rad * 4, 2) << "side by side: closer than the tool is wide";
}

constexpr char kNibblingTool[] = "$\nT1D2.4\n$\n";

/// "Slot length = 10 mm + 2.4 mm = 12.4 mm", with a tool of 2.4 mm; "the outer holes are drilled
/// first. The following drilling runs produce drill holes between already drilled holes."
TEST(ManualG85, NibblesASlotOfTwelvePointFourMillimeters) {
  const ProgramRun run =
      run_program("%%5000\nX10.Y10.G85T1\nX20.Y10.\n" + std::string(kNibblingTool));
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  const Places places = hole_places(run);
  ASSERT_GE(places.size(), 5U);
  expect_same_places({places[0], places[1]}, {{10, 10}, {20, 10}});
  std::vector<double> x_mm;
  for (const Vector2d& place : places) {
    EXPECT_NEAR(place.y(), 10, 1e-9);
    x_mm.push_back(place.x());
  }
  std::ranges::sort(x_mm);
  EXPECT_NEAR(x_mm.front(), 10, 1e-9);
  EXPECT_NEAR(x_mm.back(), 20, 1e-9);
  for (std::size_t i = 1; i < x_mm.size(); ++i) {
    EXPECT_GT(x_mm[i], x_mm[i - 1] + 1e-6) << "no hole twice";
    EXPECT_LT(x_mm[i] - x_mm[i - 1], 2.4) << "side by side";
  }
}

TEST(ManualG85, DrillingGoesOnBehindTheSlot) {
  const ProgramRun run =
      run_program("%%5000\nX10.Y10.G85T1\nX20.Y10.\nX50.Y50.\n" + std::string(kNibblingTool));
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  const Places places = hole_places(run);
  EXPECT_EQ(std::ranges::count_if(places, [](const Vector2d& p) { return p.y() > 11; }), 1);
  EXPECT_THAT(places.back(), IsNearMatrix(Vector2d(50, 50), 1e-9));
}

// --- chapter 2.4, M97 and M98 --------------------------------------------------------------------

struct Extent {
  Vector2d low_mm = Vector2d::Constant(1e9);
  Vector2d high_mm = Vector2d::Constant(-1e9);
};

Extent extent_of(const ProgramRun& run, int tool) {
  Extent extent;
  for (const test::Hole& hole : run.holes()) {
    if (hole.drill.tool != tool) continue;
    extent.low_mm = extent.low_mm.cwiseMin(hole.nominal_mm());
    extent.high_mm = extent.high_mm.cwiseMax(hole.nominal_mm());
  }
  return extent;
}

/// T4 of 1 mm gives characters of 8.2 mm, T5 of 2 mm such of 16.4 mm: 8.2 diameters from edge to
/// edge. "The reference point is always the grid point GP(1.7)", the lower left one.
TEST(ManualPlainText, HeightsOfCncAlongXAndY) {
  const ProgramRun run = run_5000("X30.Y10.T4 M97,CNC\nX30.Y30.T5 M98,CNC\n");
  // From the first character's first column to the last one's fifth: 2 x 6 + 4 pitches.
  const double pitches = 16;
  const Extent along_x = extent_of(run, 4);
  EXPECT_NEAR(along_x.high_mm.y() - along_x.low_mm.y() + 1, 8.2, 1e-9);
  EXPECT_THAT(along_x.low_mm, IsNearMatrix(Vector2d(30, 10), 1e-9));
  EXPECT_NEAR(along_x.high_mm.x(), 30 + pitches * 1.2, 1e-9);
  // "Can be read from the front to the back when turned to the left": writing goes along +y, so
  // what is up in a character is to the left.
  const Extent along_y = extent_of(run, 5);
  EXPECT_NEAR(along_y.high_mm.x() - along_y.low_mm.x() + 2, 16.4, 1e-9);
  EXPECT_THAT(Vector2d(along_y.high_mm.x(), along_y.low_mm.y()),
              IsNearMatrix(Vector2d(30, 30), 1e-9));
  EXPECT_NEAR(along_y.high_mm.y(), 30 + pitches * 2.4, 1e-9);
}

// The label's tool is 0.8 mm in diameter, so a character is 6 x 1.2 x 0.8 mm to the next.
constexpr double kLabelAdvance_mm = 5.76;

ProgramRun pattern_label(int run_number) {
  WalkOptions options;
  options.sieb_meyer.text.run = run_number;
  return run_program(
      "%%5000\nX31.Y28.T1M31\nX220.Y40.M50\nX220.Y140.M50\nXYM50M30\n"
      "X42.Y13.T2M31\nX220.Y40.M50\nX220.Y140.M50\nXYM50M30\n(PATTERN LABEL)\n"
      "X30.Y10.T7M31M97,A2341-&N-&R\nX220.Y40.M50\nX220.Y140.M50\nXYM50M30\n"
      "$\nT1D1.\nT2D2.\nT7D.8\n$\n",
      options);
}

/// The holes of one character of one pattern's label, from the character's reference point.
Places label_character(const ProgramRun& run, int pattern, int i_character) {
  const std::vector<Vector2d> zeros = {{220, 40}, {220, 140}, {0, 0}};
  Places places;
  for (const test::Hole& hole : run.holes()) {
    if (hole.drill.tool != 7 || hole.path != InstancePath{pattern}) continue;
    const Vector2d zero = zeros[static_cast<std::size_t>(pattern)];
    const Vector2d in_text = hole.nominal_mm() - zero - Vector2d(30, 10);
    const int i = static_cast<int>(std::floor(in_text.x() / kLabelAdvance_mm + 1e-6));
    if (i != i_character) continue;
    places.emplace_back(in_text - Vector2d(i * kLabelAdvance_mm, 0));
  }
  return places;
}

bool is_same_shape(const Places& a, const Places& b) {
  return std::ranges::equal(
      a, b, [](const Vector2d& p, const Vector2d& q) { return (p - q).norm() < 1e-6; });
}

constexpr int kRunDigit = 6;      // of A2341-1-1
constexpr int kPatternDigit = 8;  // its last character

/// "X..Y..M50M30 last pattern zero" is printed XYM50M30: here it is X0Y0.
TEST(ManualPatternLabel, EveryPatternHasItsNumber) {
  const ProgramRun run = pattern_label(1);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  const Places other_holes = hole_places(run);
  expect_places({other_holes.begin(), other_holes.begin() + 6},
                {{251, 68}, {251, 168}, {31, 28}, {262, 53}, {262, 153}, {42, 13}});
  for (int i = 0; i < kPatternDigit; ++i) {
    const Places first = label_character(run, 0, i);
    EXPECT_FALSE(first.empty()) << i;
    EXPECT_TRUE(is_same_shape(first, label_character(run, 1, i))) << i;
    EXPECT_TRUE(is_same_shape(first, label_character(run, 2, i))) << i;
  }
  // "A2341-1-1" to "A2341-1-3"
  const Places one = label_character(run, 0, kPatternDigit);
  const Places two = label_character(run, 1, kPatternDigit);
  const Places three = label_character(run, 2, kPatternDigit);
  EXPECT_TRUE(is_same_shape(one, label_character(run, 0, kRunDigit)));
  EXPECT_FALSE(is_same_shape(one, two));
  EXPECT_FALSE(is_same_shape(one, three));
  EXPECT_FALSE(is_same_shape(two, three));
  EXPECT_TRUE(is_same_shape(two, label_character(run, 1, 1))) << "the 2 of A2341";
  EXPECT_TRUE(is_same_shape(three, label_character(run, 2, 2))) << "the 3 of A2341";
}

TEST(ManualPatternLabel, BeginsAtItsReferencePoint) {
  const ProgramRun run = pattern_label(1);
  const std::vector<Vector2d> zeros = {{220, 40}, {220, 140}, {0, 0}};
  for (int pattern = 0; pattern < 3; ++pattern) {
    const auto first = std::ranges::find_if(run.holes(), [&](const test::Hole& hole) {
      return hole.drill.tool == 7 && hole.path == InstancePath{pattern};
    });
    ASSERT_NE(first, run.holes().end());
    EXPECT_THAT(
        first->nominal_mm(),
        IsNearMatrix(Vector2d(zeros[static_cast<std::size_t>(pattern)] + Vector2d(30, 10)), 1e-9));
  }
}

/// The table "Drilled codes": run 2 drills A2341-2-1 to A2341-2-3.
TEST(ManualPatternLabel, TheSecondRunDiffersByItsNumber) {
  const ProgramRun first = pattern_label(1);
  const ProgramRun second = pattern_label(2);
  for (int i = 0; i <= kPatternDigit; ++i) {
    EXPECT_EQ(is_same_shape(label_character(first, 1, i), label_character(second, 1, i)),
              i != kRunDigit)
        << i;
  }
  EXPECT_TRUE(is_same_shape(label_character(second, 1, kRunDigit),
                            label_character(second, 1, kPatternDigit)))
      << "A2341-2-2";
}

// --- chapters 2.6 to 2.8: what is passed on ------------------------------------------------------

TEST(ManualG81, PeckDrillingIsPassedOnBeforeItsHole) {
  const ProgramRun run = run_5000("X2.Y7.T2 G81I5.P80 J1.4W1000Z1.0\nX3.Y7.\nX4.Y7.G80\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 2",
                          testing::StartsWith("function peck_on G81I5.P80"),
                          "drill 2 (2, 7) z 1",
                          "drill 2 (3, 7) z 1",
                          "function peck_off G80",
                          "drill 2 (4, 7) z 1"));
}

TEST(ManualG89, PulseDrillingIsPassedOnBeforeItsHole) {
  const ProgramRun run = run_5000("X123.456Y789.123T2 G89I5.J1.4 E30 R0.2Z1.8\nX10.Y10.G88\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 2",
                          testing::StartsWith("function pulse_on G89I5.J1.4"),
                          "drill 2 (123.456, 789.123) z 1.8",
                          "function pulse_off G88",
                          "drill 2 (10, 10) z 1.8"));
}

TEST(ManualM56, CheckAreasArePassedOn) {
  const ProgramRun run = run_5000("X10.Y20.M56\nX450.Y20.M57\nX1.Y1.T1\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("function check_area X10.000Y20.000M56",
                          "function check_area X450.000Y20.000M57",
                          "tool 1",
                          "drill 1 (1, 1)"));
}

}  // namespace
}  // namespace panelcal
