// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/step_repeat.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::Hole;
using test::inch_leading_zeros;
using test::IsNearMatrix;
using test::nominal_inch;
using test::ProgramRun;
using test::run_program;

/// Inches come from millimetres by one division.
constexpr double kRounding_inch = 1e-12;

std::vector<Vector2d> holes_of(std::string_view body) {
  const ProgramRun run = run_program(inch_leading_zeros("T1\n" + std::string(body) + "M30\n"));
  EXPECT_FALSE(run.has_errors) << run.diagnostics.front();
  return nominal_inch(run);
}

void expect_places(const std::vector<Vector2d>& places, const std::vector<Vector2d>& expected) {
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_THAT(places[i], IsNearMatrix(expected[i], kRounding_inch)) << "hole " << i;
  }
}

std::vector<std::string> paths_of(const ProgramRun& run) {
  std::vector<std::string> paths;
  for (const Hole& hole : run.holes()) {
    std::string text;
    for (const int index : hole.path) text += std::to_string(index);
    paths.push_back(text);
  }
  return paths;
}

// --- CNC-7 manual, Step and Repeat Commands ------------------------------------------------------

TEST(StepRepeat, M02IsTheDistanceFromTheLastPattern) {
  expect_places(holes_of("M25\nX01Y01\nM01\nM02X02\nM02X02Y01\nM02\nM08\n"),
                {{1, 1}, {3, 1}, {5, 2}});
}

TEST(StepRepeat, ABareM02ClearsTheOffsetCounter) {
  expect_places(holes_of("M25\nX01Y01\nM01\nM02X02\nM02\nM02Y03\nM08\n"), {{1, 1}, {3, 1}, {1, 4}});
}

TEST(StepRepeat, PercentBeginsAPatternLikeM25) {
  expect_places(holes_of("%\nX01Y01\nM01\nM02X02\nM08\n"), {{1, 1}, {3, 1}});
}

/// "After the last M02 repeat command, an extra M02 command which requires no coordinates, must be
/// added in a block by itself": without it the next offsets might count on from these.
TEST(StepRepeat, SaysWhereOffsetsCountAnewWithoutABareM02) {
  const auto diagnostics_of = [](const std::string& levels) {
    return run_program(inch_leading_zeros("T1\nM25\nX01Y01\nM01\n" + levels + "M30\n")).diagnostics;
  };
  const std::vector<std::string> warned = {"p.exc:12:1: warning[notation-accepted]"};
  EXPECT_EQ(diagnostics_of("M02X02\nM01\nM02Y02\nM01\nM02Y04\nM08\n"), warned);
  EXPECT_EQ(diagnostics_of("M02X02\nM08\n"), std::vector<std::string>{});
  EXPECT_EQ(diagnostics_of("M02X02\nM02\nM01\nM02Y02\nM02\nM08\n"), std::vector<std::string>{});
  // The manual's sample program, lines 36 to 42.
  EXPECT_EQ(diagnostics_of("R2M02XY001\nM01\nR2M02X007Y\nM08\n"), std::vector<std::string>{});
  EXPECT_EQ(diagnostics_of("M02X02\nM08\nM25\nX02Y02\nM01\nM02X02\nM02X02\nM08\n"),
            std::vector<std::string>{"p.exc:15:1: warning[notation-accepted]"});
}

TEST(StepRepeat, RepeatBlockEqualsThatManyM02) {
  const std::vector<Vector2d> column = {{1, 1}, {1, 3}, {1, 5}, {1, 7}};
  expect_places(holes_of("M25\nX01Y01\nM01\nR3M02Y02\nM08\n"), column);
  expect_places(holes_of("M25\nX01Y01\nM01\nR3M02XY02\nM08\n"), column);
  expect_places(holes_of("M25\nX01Y01\nM01\nM02Y02\nM02Y02\nM02Y02\nM02\nM08\n"), column);
}

TEST(StepRepeat, ThreeLevelsOfR2AreTwentySevenCopies) {
  const auto holes = holes_of("M25\nXY\nM01\nR2M02X001\nM01\nR2M02Y001\nM01\nR2M02X01Y01\nM08\n");
  EXPECT_EQ(holes.size(), 27U);
  EXPECT_THAT(holes.back(), IsNearMatrix(Vector2d(2.2, 2.2), kRounding_inch));
}

TEST(StepRepeat, ManualNestedExampleMakesEightPatterns) {
  // Two patterns, then four, then eight (Nested Step and Repeat Commands).
  const auto holes = holes_of("M25\nXY\nM01\nM02X01\nM01\nM02Y01\nM01\nM02X04\nM08\n");
  EXPECT_EQ(holes.size(), 8U);
}

TEST(StepRepeat, M80MirrorsXAndM90MirrorsY) {
  expect_places(holes_of("M25\nX01Y02\nM01\nM02X10M80\nM02X10M90\nM08\n"),
                {{1, 2}, {9, 2}, {21, -2}});
}

TEST(StepRepeat, M70SwapsTheAxes) {
  expect_places(holes_of("M25\nX01Y02\nM01\nM02X10M70\nM08\n"), {{1, 2}, {12, 1}});
}

TEST(StepRepeat, MirrorsActBeforeSwap) {
  expect_places(holes_of("M25\nX01Y02\nM01\nM02M80M70\nM02M70M90\nM08\n"),
                {{1, 2}, {2, -1}, {-2, 1}});
}

/// All of the manual's examples have the mirrors ahead of M70.
TEST(StepRepeat, WarnsOfM70AheadOfAMirrorOnce) {
  const auto warned = [](const std::string& body) {
    return run_program(inch_leading_zeros("T1\n" + body + "M30\n")).diagnostics;
  };
  EXPECT_TRUE(warned("M25\nX01Y02\nM01\nM02X10M80M90M70\nM02\nM08\n").empty());
  EXPECT_THAT(warned("M25\nX01Y02\nM01\nM02X10M70M80\nM02X10M70M90\nM02\nM08\n"),
              testing::ElementsAre(testing::HasSubstr("warning[notation-accepted]")));
}

TEST(StepRepeat, AMirrorActsOnThatCopyOnly) {
  expect_places(holes_of("M25\nX01Y02\nM01\nM02X10M80\nM02X10\nM08\n"), {{1, 2}, {9, 2}, {21, 2}});
}

TEST(StepRepeat, RepeatBlockRepeatsItsMirrorToo) {
  expect_places(holes_of("M25\nX01Y02\nM01\nR2M02X10M80\nM08\n"), {{1, 2}, {9, 2}, {19, 2}});
}

TEST(StepRepeat, AnOuterMirrorTurnsTheInnerOffsetsOver) {
  expect_places(holes_of("M25\nX01Y\nM01\nM02X02\nM01\nM02X20M80\nM08\n"),
                {{1, 0}, {3, 0}, {19, 0}, {17, 0}});
}

TEST(StepRepeat, PathsNameTheInstanceOutermostFirst) {
  const ProgramRun run =
      run_program(inch_leading_zeros("T1\nXY\nM25\nXY\nM01\nR2M02X01\nM01\nM02Y01\nM08\nM30\n"));
  EXPECT_EQ(paths_of(run), (std::vector<std::string>{"", "00", "01", "02", "10", "11", "12"}));
}

TEST(StepRepeat, ABareM02DoesNotCountAsAnInstance) {
  const ProgramRun run =
      run_program(inch_leading_zeros("T1\nM25\nXY\nM01\nM02X01\nM02\nM02X02\nM08\nM30\n"));
  EXPECT_EQ(paths_of(run), (std::vector<std::string>{"0", "1", "2"}));
}

TEST(StepRepeat, ToolsInAPatternChangeInEveryCopy) {
  const ProgramRun run =
      run_program(inch_leading_zeros("T1\nM25\nXY\nT2\nX01Y01\nM01\nM02X05\nM08\nM30\n"));
  ASSERT_EQ(run.holes().size(), 4U);
  // The copy begins with the tool that the first pass ended with.
  EXPECT_EQ(run.holes()[1].drill.tool, 2);
  EXPECT_EQ(run.holes()[2].drill.tool, 2);
}

TEST(StepRepeat, ACopyReadsOmittedAxesAsTheFirstPassDid) {
  expect_places(holes_of("X03Y04\nM25\nX05Y04\nY06\nM01\nM02X10\nM08\n"),
                {{3, 4}, {5, 4}, {5, 6}, {15, 4}, {15, 6}});
}

TEST(StepRepeat, ACopyBeginsInTheModeOfTheFirstPass) {
  expect_places(holes_of("X01Y01\nM25\nX02Y02\nG91\nX001\nM01\nM02X10\nM08\n"),
                {{1, 1}, {2, 2}, {2.1, 2}, {12, 2}, {12.1, 2}});
}

/// "M02 causes a repeat of all the commands", and "creates two identical patterns": the feed that a
/// copy begins with is said where the two differ.
TEST(StepRepeat, CopiesRoutAtTheFeedsOfTheirPattern) {
  const auto run_of = [](const std::string& pattern, const std::string& copies) {
    return run_program(inch_leading_zeros("T1\nG00XY\nM25\nG00X01Y01\nM15\n" + pattern +
                                          "M17\nM01\n" + copies + "M08\nM30\n"));
  };
  const std::string late = "G01X02\nF02\nX03\n";
  const ProgramRun run = run_of(late, "M02Y03\nM02Y03\nM02\n");
  EXPECT_EQ(run.diagnostics, std::vector<std::string>{"p.exc:12:1: warning[feed-assumed]"});
  std::vector<double> feeds;
  for (const Rout& rout : run.executed.routs()) feeds.push_back(rout.feed / inch_per_min(1));
  EXPECT_THAT(feeds,
              testing::Pointwise(testing::DoubleNear(1e-9),
                                 std::vector<double>{100, 20, 100, 20, 100, 20}));
  EXPECT_EQ(run_of(late, "").diagnostics, std::vector<std::string>{});
  EXPECT_EQ(run_of("G01X02F02\nX03\n", "M02Y03\n").diagnostics, std::vector<std::string>{});
  EXPECT_EQ(run_of("F02\nG01X02\nX03\nF04\n", "M02Y03\n").diagnostics, std::vector<std::string>{});
}

// --- the manual's Sample Part Program ------------------------------------------------------------

TEST(StepRepeat, ManualSampleProgramLines31To42) {
  const ProgramRun run = run_program(inch_leading_zeros(
      "M47,DRILL DEMO\nG05\nM72\nG93X0325Y015\nT1\n"
      "M25\nX042Y01\nR9X0005\nY0105\nR9X-0005\nM01\nR2M02XY001\nM01\nR2M02X007Y\nM01\nR2M02XY007\n"
      "M08\nM30\n"));
  ASSERT_FALSE(run.has_errors);
  ASSERT_EQ(run.holes().size(), 27U * 20U);
  const auto places = nominal_inch(run);
  EXPECT_THAT(places[0], IsNearMatrix(Vector2d(4.2, 1.0), kRounding_inch));
  EXPECT_THAT(places[9], IsNearMatrix(Vector2d(4.65, 1.0), kRounding_inch));
  EXPECT_THAT(places[10], IsNearMatrix(Vector2d(4.65, 1.05), kRounding_inch));
  EXPECT_THAT(places[19], IsNearMatrix(Vector2d(4.2, 1.05), kRounding_inch));
  EXPECT_THAT(places[20], IsNearMatrix(Vector2d(4.2, 1.1), kRounding_inch));
  EXPECT_THAT(places[60], IsNearMatrix(Vector2d(4.9, 1.0), kRounding_inch));
  EXPECT_THAT(places[180], IsNearMatrix(Vector2d(4.2, 1.7), kRounding_inch));
  EXPECT_THAT(places.back(), IsNearMatrix(Vector2d(5.6, 2.65), kRounding_inch));
  // Work zero is the zero set.
  EXPECT_THAT(Vector2d(run.holes()[0].actual_mm() / 25.4),
              IsNearMatrix(Vector2d(7.45, 2.5), kRounding_inch));
}

TEST(StepRepeat, ManualSampleProgramLines83To96) {
  const auto places = holes_of(
      "M25\nX01Y018\nR8Y-001\nR4X001\nM01\n"
      "M02X002Y002M70\nM02X043M90M70\nM02X002Y-002M80\nM02X-002Y038M80M90M70\nM02X002Y002M80M90\n"
      "M02X-047M90\nM02X002Y-002M80M70\nM02\nM08\n");
  ASSERT_EQ(places.size(), 104U);  // the hits that the manual states for T4
  const std::vector<Vector2d> corners = {
      {1, 1}, {1.2, 1.2}, {3.5, 1.2}, {3.7, 1}, {3.5, 2.8}, {3.7, 3}, {1, 3}, {1.2, 2.8}};
  std::vector<Vector2d> found;
  for (std::size_t copy = 0; copy < 8; ++copy) {
    found.push_back(places[13 * copy + 8]);
    // Eight steps of 0.1 along one side, four along the other, at right angles.
    const Vector2d long_side = places[13 * copy] - found.back();
    const Vector2d short_side = places[13 * copy + 12] - found.back();
    EXPECT_NEAR(long_side.norm(), 0.8, kRounding_inch);
    EXPECT_NEAR(short_side.norm(), 0.4, kRounding_inch);
    EXPECT_NEAR(long_side.dot(short_side), 0, kRounding_inch);
  }
  // The manual draws no order; these are the corners of its two rectangles.
  for (const Vector2d& corner : corners) {
    EXPECT_TRUE(std::ranges::any_of(found, [&](const Vector2d& place) {
      return (place - corner).norm() < kRounding_inch;
    })) << corner.transpose();
  }
}

}  // namespace
}  // namespace panelcal
