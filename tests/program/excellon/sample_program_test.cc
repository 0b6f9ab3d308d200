// SPDX-License-Identifier: Apache-2.0
// CNC-7 manual, Sample Part Program, whole: data/sample.exc has the manual's block n in line n.
// Line 54 is G04X005 (a slip of the manual). The blocks printed to the right of blocks 110 to 123
// are the pattern LOGO: with them T5 drills the 76 and T6 the 57 holes that the manual states.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/folders.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::Hole;
using test::IsNearMatrix;
using test::ProgramRun;
using testing::AllOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;

constexpr double kRounding_inch = 1e-9;

ProgramRun run_sample(const WalkOptions& options = {}) {
  const auto source = read_source(test::source_folder() / "tests/program/data/sample.exc");
  EXPECT_TRUE(source);
  if (!source) return {};
  ReadOptions reading;
  reading.pattern_folders = {test::source_folder() / "tests/program/data"};
  ProgramRun run = test::run_program(source->bytes, options, reading);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

std::vector<Vector2d> holes_of_tool(const ProgramRun& run, int tool) {
  std::vector<Vector2d> places;
  for (const Hole& hole : run.holes()) {
    if (hole.drill.tool == tool) places.push_back(hole.nominal_inch());
  }
  return places;
}

bool has_hole(const std::vector<Vector2d>& places, const Vector2d& at) {
  return std::ranges::any_of(
      places, [&](const Vector2d& place) { return (place - at).norm() < kRounding_inch; });
}

TEST(SampleProgram, DrillsTheHitsThatItsListingMakes) {
  std::map<int, int> hits;
  const ProgramRun run = run_sample();
  for (const Hole& hole : run.holes()) ++hits[hole.drill.tool];
  EXPECT_EQ(hits[1], 27 * 20 + 2 * 8);  // the manual says 339
  EXPECT_EQ(hits[3], 134);
  EXPECT_EQ(hits[4], 104);
  EXPECT_EQ(hits[5], 76);
  EXPECT_EQ(hits[6], 57);
  // The manual says 78; 87 holes are the fewest that leave less than 0.0005 inch on the wall.
  EXPECT_EQ(hits[7], 87 + 1);
  EXPECT_EQ(hits[8], 3);
}

TEST(SampleProgram, TakesTheToolsInItsOrder) {
  const ProgramRun run = run_sample();
  std::vector<int> numbers;
  for (const Tool& tool : run.executed.tools()) numbers.push_back(tool.number);
  EXPECT_EQ(numbers, (std::vector<int>{1, 2, 3, 4, 5, 6, 8, 7}));
}

TEST(SampleProgram, StopsAfterTheHeaderShowsItsMessageDwellsAndEnds) {
  const ProgramRun run = run_sample();
  ASSERT_FALSE(run.executed.lines().empty());
  EXPECT_THAT(run.executed.lines(),
              AllOf(Contains("25 header_end"),
                    Contains("26 message DRILL DEMO"),
                    Contains("54 dwell 5"),
                    Contains(HasSubstr("G04")).Times(0)));
  EXPECT_EQ(run.executed.lines().back(), "141 end rewind");
}

TEST(SampleProgram, WorkZeroIsItsZeroSet) {
  const ProgramRun run = run_sample();
  ASSERT_FALSE(run.holes().empty());
  for (const Hole& hole : run.holes()) {
    EXPECT_THAT(Vector2d((hole.actual_mm() - hole.nominal_mm()) / kMmPerInch),
                IsNearMatrix(Vector2d(3.25, 1.5), kRounding_inch));
  }
}

TEST(SampleProgram, ToolFourDrillsTwoConcentricRectanglesOfCorners) {
  const std::vector<Vector2d> places = holes_of_tool(run_sample(), 4);
  for (const Vector2d& corner : std::vector<Vector2d>{
           {1, 1}, {1.2, 1.2}, {3.5, 1.2}, {3.7, 1}, {3.5, 2.8}, {3.7, 3}, {1, 3}, {1.2, 2.8}}) {
    SCOPED_TRACE(testing::Message() << "corner " << corner.transpose());
    EXPECT_TRUE(has_hole(places, corner));
    // One arm along x and one along y.
    EXPECT_NE(has_hole(places, corner + Vector2d(0.1, 0)),
              has_hole(places, corner - Vector2d(0.1, 0)));
    EXPECT_NE(has_hole(places, corner + Vector2d(0, 0.1)),
              has_hole(places, corner - Vector2d(0, 0.1)));
  }
}

TEST(SampleProgram, TheStoredPatternLiesAtItsReferenceLocation) {
  const ProgramRun run = run_sample();
  const std::vector<Vector2d> logo = holes_of_tool(run, 5);
  ASSERT_EQ(logo.size(), 76U);
  EXPECT_THAT(logo.front(), IsNearMatrix(Vector2d(1.5, 2.1), kRounding_inch));
  EXPECT_THAT(logo[63], IsNearMatrix(Vector2d(1.6, 2.1), kRounding_inch));  // the outline closes
  EXPECT_THAT(logo[64], IsNearMatrix(Vector2d(2.7, 2.1), kRounding_inch));
  EXPECT_THAT(logo.back(), IsNearMatrix(Vector2d(2.6, 2.1), kRounding_inch));
  EXPECT_THAT(run.executed.lines(),
              Contains(AllOf(HasSubstr("LOGO:1 drill 5 "), EndsWith("(120.65, 91.44)"))));
}

TEST(SampleProgram, IncrementalModeDrawsASquareAndRepeatedHolesADiamond) {
  const std::vector<Vector2d> places = holes_of_tool(run_sample(), 6);
  ASSERT_EQ(places.size(), 57U);
  const auto expect_hole = [&](std::size_t i, double x, double y) {
    EXPECT_THAT(places[i], IsNearMatrix(Vector2d(x, y), kRounding_inch)) << "hole " << i;
  };
  expect_hole(0, 0.25, 1);    // line 101: the zero of LOGO is dropped
  expect_hole(5, 0.25, 1.5);  // line 107
  expect_hole(10, 0.75, 1.5);
  expect_hole(15, 0.75, 1);
  expect_hole(20, 0.25, 1);
  expect_hole(25, 0.25, 1.5);  // line 124, in absolute mode again
  expect_hole(30, 0.75, 1.5);
  expect_hole(35, 0.75, 1);
  expect_hole(39, 0.35, 1);
  expect_hole(40, 1.6, 4.6);  // line 128
  expect_hole(44, 2, 5);
  expect_hole(48, 2.4, 4.6);
  expect_hole(52, 2, 4.2);
  expect_hole(55, 1.7, 4.5);
  expect_hole(56, 3, 4.6);  // line 133
}

TEST(SampleProgram, ToolSevenDrillsACircleAndProgramZero) {
  const std::vector<Vector2d> places = holes_of_tool(run_sample(), 7);
  ASSERT_FALSE(places.empty());
  EXPECT_THAT(places.back(), IsNearMatrix(Vector2d(0, 0), kRounding_inch));
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    EXPECT_NEAR((places[i] - Vector2d(0.9, 4.6)).norm(), (0.5 - 0.125) / 2, kRounding_inch);
  }
}

TEST(SampleProgram, ToolEightDrillsThreeHoles) {
  const std::vector<Vector2d> places = holes_of_tool(run_sample(), 8);
  ASSERT_EQ(places.size(), 3U);
  EXPECT_THAT(places[0], IsNearMatrix(Vector2d(0.5, 4.1), kRounding_inch));
  EXPECT_THAT(places[1], IsNearMatrix(Vector2d(0.9, 4.6), kRounding_inch));
  EXPECT_THAT(places[2], IsNearMatrix(Vector2d(1.3, 4.1), kRounding_inch));
}

TEST(SampleProgram, ItsSlotsMayBeKept) {
  WalkOptions options;
  options.slots = options.step_slots = Cycles::Kept;
  EXPECT_THAT(run_sample(options).executed.lines(), Contains(HasSubstr(" slot 2 ")).Times(8));
}

}  // namespace
}  // namespace panelcal
