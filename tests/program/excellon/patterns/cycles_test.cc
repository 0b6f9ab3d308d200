// SPDX-License-Identifier: Apache-2.0
// Canned cycles: CNC-7 manual, Excellon Supplied Stored Patterns, Repeat Stored Pattern. Where the
// manual names no order, places are compared without one.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
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
using test::joined;
using test::kRounding_inch;
using test::Places;
using test::ProgramRun;
using test::row;
using test::run_program;
using test::says;
using test::shifted;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

/// Height that the manual lets protrude between the holes of a circle or slot.
constexpr double kScallop_inch = 0.0005;

/// Two rows along x.
Places package(double x, double pitch, int count, double y1, double y2) {
  return joined(row({x, y1}, {pitch, 0}, count), row({x, y2}, {pitch, 0}, count));
}

TEST(DualInLine, ManualSampleProgramLines66To77) {
  expect_same_places(holes_of("G82\nX005Y033\nX012Y036\n"), package(0.5, 0.1, 8, 3.3, 3.6));
  // The corners are 0.3 apart where the block says 0.4: the rows run through both corners.
  expect_same_places(holes_of("G82X.1Y.4\nX02Y033\nX033Y036\n"), package(2, 0.1, 14, 3.3, 3.6));
  expect_same_places(holes_of("G82X.2Y.5\nX04Y033\nX054Y038\n"), package(4, 0.2, 8, 3.3, 3.8));
  expect_same_places(holes_of("G82X.1Y.6\nX04Y023\nX055Y029\n"), package(4, 0.1, 16, 2.3, 2.9));
}

/// 14 pins, 0.1 x 0.3: rows along y, 0.3 apart in x.
Places upright_package() {
  return joined(row({3.7, 4.2}, {0, 0.1}, 7), row({4, 4.2}, {0, 0.1}, 7));
}

TEST(DualInLine, ManualSampleProgramLines78To81) {
  const Places one = upright_package();
  const Places three = joined(joined(one, shifted(one, {0.7, 0})), shifted(one, {1.4, 0}));
  expect_same_places(holes_of("G82\nX037Y042\nX04Y048\n"), one);
  expect_same_places(holes_of("G82\nX037Y042\nX04Y048\nP2X007\n"), three);
}

TEST(DualInLine, G81IsTheSameInFormatTwo) {
  expect_same_places(holes_of("G81\nX037Y042\nX04Y048\n"), upright_package());
  expect_same_places(holes_of("G81X.2Y.5\nX04Y033\nX054Y038\n"), package(4, 0.2, 8, 3.3, 3.8));
}

TEST(DualInLine, TheCornersMayComeInAnyOrder) {
  for (const char* corners :
       {"X04Y048\nX037Y042\n", "X037Y048\nX04Y042\n", "X04Y042\nX037Y048\n"}) {
    expect_same_places(holes_of(std::string("G82\n") + corners), upright_package());
  }
}

TEST(DualInLine, TheRowSpacingDecidesTheDirectionBeforeTheLongerSide) {
  // 0.5 lies along y, so that the rows run along x, the shorter side.
  expect_same_places(holes_of("G82X.1Y.5\nXY\nX003Y005\n"), package(0, 0.1, 4, 0, 0.5));
}

TEST(DualInLine, ASquareIsAnError) {
  EXPECT_THAT(diagnostics_of("G82\nX01Y01\nX013Y013\n"),
              Contains(HasSubstr("error[cycle-invalid]")));
  EXPECT_THAT(diagnostics_of("G82\nX01Y01\nX02Y02\n"), Contains(HasSubstr("error[cycle-invalid]")));
}

TEST(DualInLine, IsCopiedAndMirroredWithItsPattern) {
  Places mirrored;
  for (const Vector2d& p : upright_package()) mirrored.emplace_back(10 - p.x(), p.y());
  expect_same_places(holes_of("M25\nG82\nX037Y042\nX04Y048\nM01\nM02X10M80\nM08\n"),
                     joined(upright_package(), mirrored));
}

TEST(DualInLine, G81IsDrillModeInFormatOne) {
  expect_same_places(
      clean_holes("M48\nINCH,LZ\nFMAT,1\nT1C.04\n%\nT1\nG81\nX037Y042\nX04Y048\nM30\n"),
      {{3.7, 4.2}, {4, 4.8}});
  expect_same_places(
      clean_holes("M48\nINCH,LZ\nFMAT,1\nT1C.04\n%\nT1\nG82\nX037Y042\nX04Y048\nM30\n"),
      upright_package());
}

// --- CNC-7 manual: Eight Pin L Pack --------------------------------------------------------------

Places eight_pins(const Vector2d& center, double radius) {
  Places places;
  for (int i = 0; i < 8; ++i) {
    const double angle_rad = i * std::numbers::pi / 4;
    places.emplace_back(center + radius * Vector2d(std::cos(angle_rad), std::sin(angle_rad)));
  }
  return places;
}

TEST(EightPin, ManualSampleProgramLines43To48) {
  expect_same_places(holes_of("G83\nX003Y041\nX007Y041\nG83\nX011Y041\nX015Y041\n"),
                     joined(eight_pins({0.5, 4.1}, 0.2), eight_pins({1.3, 4.1}, 0.2)));
}

TEST(EightPin, TheHolesGivenMayLieOnTheVerticalCenterline) {
  expect_same_places(holes_of("G83\nX005Y043\nX005Y039\n"), eight_pins({0.5, 4.1}, 0.2));
}

TEST(EightPin, TheCircleGoesThroughBothHolesGiven) {
  expect_same_places(holes_of("G83\nX01Y01\nX02Y01\n"), eight_pins({1.5, 1}, 0.5));
}

// --- CNC-7 manual: Canned Circle -----------------------------------------------------------------

/// Height to which the wall of a circle stands out between two of n holes about its circumference.
double circle_scallop_inch(int n, double circle_inch, double tool_inch) {
  const double path = (circle_inch - tool_inch) / 2;
  const double half_turn_rad = std::numbers::pi / n;
  const double across = path * std::sin(half_turn_rad);
  // Point at which two neighbouring holes meet on the outside.
  const double wall =
      path * std::cos(half_turn_rad) + std::sqrt(tool_inch * tool_inch / 4 - across * across);
  return circle_inch / 2 - wall;
}

/// Evenly spaced about the circle, as few holes as the manual's limit allows.
void expect_circle(const Places& found, const Vector2d& center, double circle, double tool) {
  std::vector<double> angles_rad;
  for (const Vector2d& hole : found) {
    EXPECT_NEAR((hole - center).norm(), (circle - tool) / 2, kRounding_inch);
    angles_rad.push_back(std::atan2(hole.y() - center.y(), hole.x() - center.x()));
  }
  std::ranges::sort(angles_rad);
  const int n = static_cast<int>(found.size());
  ASSERT_GT(n, 2);
  for (std::size_t i = 1; i < angles_rad.size(); ++i) {
    EXPECT_NEAR(angles_rad[i] - angles_rad[i - 1], 2 * std::numbers::pi / n, 1e-7);
  }
  EXPECT_LT(circle_scallop_inch(n, circle, tool), kScallop_inch);
  EXPECT_GE(circle_scallop_inch(n - 1, circle, tool), kScallop_inch);
}

TEST(CannedCircle, ManualSampleProgramLine139) {
  const Places found = clean_holes("M48\nINCH,LZ\nT7C.125\n%\nT7\nX009Y046G84X005\nM30\n");
  expect_circle(found, {0.9, 4.6}, 0.5, 0.125);
}

TEST(CannedCircle, TakesAnEighthOfAnInchForAToolWithoutDiameter) {
  expect_circle(
      clean_holes("M48\nINCH,LZ\nT7F2\n%\nT7\nX009Y046G84X005\nM30\n"), {0.9, 4.6}, 0.5, 0.125);
}

TEST(CannedCircle, TheSmallestIsTwiceTheTool) {
  expect_circle(holes_of("X01Y01G84X.08\n"), {1, 1}, 0.08, 0.04);
  EXPECT_THAT(diagnostics_of("X01Y01G84X.0799\n"), Contains(says(7, "error[cycle-invalid]")));
}

TEST(CannedCircle, IsRepeatedByP) {
  const Places one = holes_of("X01Y01G84X.2\n");
  expect_same_places(holes_of("X01Y01G84X.2\nP1X01Y02\n"), joined(one, shifted(one, {1, 2})));
}

// --- CNC-7 manual: Slot --------------------------------------------------------------------------

/// Height to which the wall of a slot stands out between two holes.
double slot_scallop_inch(double pitch_inch, double tool_inch) {
  return tool_inch / 2 - std::sqrt(tool_inch * tool_inch / 4 - pitch_inch * pitch_inch / 4);
}

/// `found` in the order of drilling.
void expect_slot(const Places& found, const Vector2d& start, const Vector2d& end, double tool) {
  const double length = (end - start).norm();
  const Vector2d along = (end - start) / length;
  std::vector<double> distances;
  for (const Vector2d& hole : found) {
    distances.push_back(along.dot(hole - start));
    EXPECT_NEAR(((hole - start) - distances.back() * along).norm(), 0, kRounding_inch);
  }
  ASSERT_GT(distances.size(), 2U);

  // The first pass goes from one end to the other and leaves material between its holes.
  const auto turn = std::ranges::is_sorted_until(distances);
  EXPECT_NEAR(distances.front(), 0, kRounding_inch);
  EXPECT_NEAR(*(turn - 1), length, kRounding_inch);
  for (auto at = distances.begin() + 1; at != turn; ++at) {
    EXPECT_GE(*at - *(at - 1), tool - kRounding_inch);
  }

  std::ranges::sort(distances);
  const double pitch = length / static_cast<double>(distances.size() - 1);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    EXPECT_NEAR(distances[i], static_cast<double>(i) * pitch, kRounding_inch);
  }
  EXPECT_LT(slot_scallop_inch(pitch, tool), kScallop_inch);
  EXPECT_GE(slot_scallop_inch(2 * pitch, tool), kScallop_inch);  // not a pass too many
}

std::string with_tool_two(const std::string& body) {
  return "M48\nINCH,LZ\nT2C.032\n%\nT2\n" + body + "M30\n";
}

TEST(CannedSlot, ManualSampleProgramLines50To58) {
  struct Case {
    std::string block;
    Vector2d start, end;
  };
  for (const Case& one : std::vector<Case>{{"X03Y05G85X03Y047\n", {3, 5}, {3, 4.7}},
                                           {"X034Y046G85X031Y046\n", {3.4, 4.6}, {3.1, 4.6}},
                                           {"X03Y042G85X03Y045\n", {3, 4.2}, {3, 4.5}},
                                           {"X026Y046G85X03Y045\n", {2.6, 4.6}, {3, 4.5}},
                                           {"X032Y047G85X033Y049\n", {3.2, 4.7}, {3.3, 4.9}},
                                           {"X031Y045G85X033Y043\n", {3.1, 4.5}, {3.3, 4.3}},
                                           {"X029Y049G85X027Y043\n", {2.9, 4.9}, {2.7, 4.3}},
                                           {"X027Y049G85X029Y047\n", {2.7, 4.9}, {2.9, 4.7}}}) {
    SCOPED_TRACE(one.block);
    expect_slot(clean_holes(with_tool_two(one.block)), one.start, one.end, 0.032);
  }
}

TEST(CannedSlot, NeedsTheDiameter) {
  EXPECT_THAT(run_program("M48\nINCH,LZ\nT2F2\n%\nT2\nX03Y05G85X03Y047\nM30\n").diagnostics,
              Contains(says(6, "error[diameter-missing]")));
}

TEST(CannedSlot, IsRepeatedByP) {
  const Places one = clean_holes(with_tool_two("X03Y05G85X03Y047\n"));
  expect_same_places(clean_holes(with_tool_two("X03Y05G85X03Y047\nP2X001\n")),
                     joined(joined(one, shifted(one, {0.1, 0})), shifted(one, {0.2, 0})));
}

TEST(CannedSlot, KeptIsOneOperation) {
  WalkOptions options;
  options.slots = options.step_slots = Cycles::Kept;
  const ProgramRun run = run_program(with_tool_two("X03Y05G85X03Y047\nP1X001\n"), options);
  EXPECT_TRUE(run.holes().empty());
  EXPECT_THAT(run.executed.lines(),
              AllOf(Contains("6 slot 2 (76.2, 127) (76.2, 119.38)").Times(1),
                    Contains(HasSubstr("slot 2 (78.74, 127) (78.74, 119.38)")).Times(1)));
}

// --- CNC-7 manual: Repeat Stored Pattern ---------------------------------------------------------

TEST(RepeatPattern, ManualExample) {
  const Places found = holes_of("G83\nX003Y041\nX007Y041\nP9X3.23\n");
  Places expected;
  for (int i = 0; i < 10; ++i) expected = joined(expected, eight_pins({0.5 + 3.23 * i, 4.1}, 0.2));
  expect_same_places(found, expected);
}

TEST(RepeatPattern, ALeadingZeroDoesNotCount) {
  EXPECT_EQ(holes_of("G83\nX003Y041\nX007Y041\nP03X01\n").size(), 32U);
}

TEST(RepeatPattern, NeedsAPatternBeforeIt) {
  EXPECT_THAT(diagnostics_of("P2X007\n"), Contains(says(7, "error[repeat-without-pattern]")));
  EXPECT_THAT(diagnostics_of("X01Y01\nP2X007\n"),
              Contains(says(8, "error[repeat-without-pattern]")));
}

TEST(RepeatPattern, NeedsADistance) {
  EXPECT_THAT(diagnostics_of("G83\nX003Y041\nX007Y041\nP2\n"), Contains(says(10, "error[")));
}

TEST(RepeatPattern, DoesNotRepeatRoutedCycles) {
  for (const char* cycle : {"G32X04Y04A005", "G33X04Y04A005", "X05Y06G87X05Y07Z-.1U.2"}) {
    EXPECT_THAT(diagnostics_of(std::string(cycle) + "\nP2X007\n"), Contains(says(8, "error[")))
        << cycle;
  }
}

TEST(Cycles, LackingTheirCoordinatesAreErrors) {
  for (const char* cycle : {"G81\n",
                            "G82\n",
                            "G82\nX01Y01\n",
                            "G82X.2Y.5\nX01Y01\n",
                            "G83\n",
                            "G83\nX01Y01\n",
                            "M97,A\n",
                            "M98,A\n"}) {
    EXPECT_THAT(diagnostics_of(cycle), Contains(HasSubstr("error[cycle-unfinished]"))) << cycle;
    EXPECT_THAT(diagnostics_of(cycle + std::string("T2\nX05Y05\n")),
                Contains(HasSubstr("error[cycle-unfinished]")))
        << cycle;
  }
}

}  // namespace
}  // namespace panelcal
