// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/gcode/gcode_leveller.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "panelcal/calib/base/random.h"
#include "tests/program/gcode/gcode_text.h"

namespace panelcal {
namespace {

using test::levelled;
using test::probed_map;
using test::sloping_map;
using ::testing::HasSubstr;

constexpr std::string_view kStart = "G21 G90\nG0 Z2\nG0 X10 Y20\n";

std::string after_start(const std::string& lines, const LevelOptions& options = {}) {
  const std::string text = levelled(std::string(kStart) + lines, sloping_map(), options);
  return text.starts_with(kStart) ? text.substr(kStart.size()) : text;
}

TEST(GcodeLeveller, FollowsASlopeWithoutCuts) {
  EXPECT_EQ(after_start("G1 Z-0.1 F100\nX60\nG0 Z2\nM2\n"),
            "G1 F100 Z-0.09\nX60 Z-0.04\nG0 Z2\nM2\n");
}

TEST(GcodeLeveller, LeavesAloneWhatIsNoMoveBelowTheSafeHeight) {
  const std::string text =
      "%\n(a board)\nG21 (mm)\nG90 G94\n\nM3 S20000\nG0 Z2.000\nG0 X10.0 Y20.00\nM5 ;off\nM2\n"
      "(the end)\n%\n";
  EXPECT_EQ(levelled(text, sloping_map()), text);
}

TEST(GcodeLeveller, KeepsOtherWordsAndComments) {
  EXPECT_EQ(after_start("N5 G1 Z-0.1 F100 M8 (down)\nN6 X20 M2 ;end\n"),
            "N5 G1 F100 M8 Z-0.09 (down)\nN6 X20 Z-0.08 M2 ;end\n");
}

TEST(GcodeLeveller, CountsInTheProgramsUnit) {
  const std::string text = "G20 G90\nG0 Z0.1\nG0 X1 Y1\nG1 Z-0.01\n";
  // 25.4 mm along the slope are 0.0254 mm, a thousandth of an inch.
  EXPECT_EQ(levelled(text, sloping_map()), "G20 G90\nG0 Z0.1\nG0 X1 Y1\nG1 Z-0.009\n");
}

TEST(GcodeLeveller, GivesEveryHoleOfACycleItsOwnDepth) {
  EXPECT_EQ(after_start("G81 X20 Y20 Z-1 R0.5 F50\nX40\nG80\n"),
            "G81 F50 X20 Y20 Z-0.98 R0.52\nX40 Z-0.96 R0.54\nG80\n");
  EXPECT_THAT(
      after_start("G99 G81 X20 Y20 Z-1 R0.05\n"),
      HasSubstr("a drilling cycle that moves on at 0.050 mm, below the safe height of 2.000"));
  LevelOptions low;
  low.safe_height = mm(0.5);
  EXPECT_EQ(after_start("G99 G81 X20 Y20 Z-1 R0.5\n", low), "G99 G81 X20 Y20 Z-0.98 R0.5\n");
}

TEST(GcodeLeveller, TurnsArcsIntoHelices) {
  // Half a circle of 5 mm from (10, 20) to (20, 20): 10 um up, 5 um off the chord at the most.
  LevelOptions rough;
  rough.height_tolerance = um(20);
  EXPECT_EQ(after_start("G1 Z-0.1\nG2 X20 Y20 I5 J0\n", rough),
            "G1 Z-0.09\nG2 X20 Y20 Z-0.08 I5 J0\n");
  EXPECT_EQ(after_start("G1 Z-0.1\nG2 X20 Y20 R5\n", rough),
            "G1 Z-0.09\nG2 X20 Y20 Z-0.08 I5 J0\n");
}

TEST(GcodeLeveller, CountsFromWhereZWasSetToZero) {
  LevelOptions options;
  options.zero = position_mm<frame::Nominal>(50, 50);
  EXPECT_EQ(after_start("G1 Z-0.1\n", options), "G1 Z-0.14\n");
}

TEST(GcodeLeveller, TellsWhatItDid) {
  const auto done =
      level_gcode({"p.ngc", std::string(kStart) + "G1 Z-0.1\nX60\nG0 Z2\n"}, sloping_map());
  ASSERT_TRUE(done);
  EXPECT_EQ(done->figures.safe_height, mm(2));
  EXPECT_EQ(done->figures.n_moves, 5);
  EXPECT_EQ(done->figures.n_levelled, 3);
  EXPECT_EQ(done->figures.n_pieces, 3);
  EXPECT_NEAR(done->figures.lowest.in_mm(), 0.01, 1e-6);
  EXPECT_NEAR(done->figures.highest.in_mm(), 0.06, 1e-6);
  EXPECT_GT(done->figures.largest_sigma, Length());
}

TEST(GcodeLeveller, TakesTheLowestTravelAboveTheBoardAsSafe) {
  // The tool parks at 30 and travels at 2; the approach at 0.05 is below the board's highest place.
  const std::string text =
      "G21\nG0 Z30\nX10 Y20\nG0 Z2\nX20\nG0 Z0.05\nX30\nG1 Z-0.1\nG0 Z30\nX500 Y500\n";
  EXPECT_EQ(
      levelled(text, sloping_map()),
      "G21\nG0 Z30\nX10 Y20\nG0 Z2\nX20\nG0 Z0.07\nX30 Z0.08\nG1 Z-0.07\nG0 Z30\nX500 Y500\n");
}

TEST(GcodeLeveller, TravelsOfCyclesCount) {
  // Rapid moves go to 0.25 inch and 1.5 inch only, between holes the tool is at 0.05 inch.
  EXPECT_EQ(levelled("G20\nG0 Z0.25\nG0 X1 Y1\nG99 G82 X1 Y1 Z-0.05 R0.05 P1\nX2\n", sloping_map()),
            "G20\nG0 Z0.25\nG0 X1 Y1\nG99 G82 P1 X1 Y1 Z-0.049 R0.05\nX2 Z-0.048 R0.05\n");
  EXPECT_THAT(levelled("G21\nG1 Z3 F9\nX10 Y10\nZ-0.1\n", sloping_map()), HasSubstr("\nZ-0.09\n"));
}

TEST(GcodeLeveller, CutsRampsAtTheSafeHeight) {
  // From 2 (safe) to -1 over 60 mm. At the safe height the tool goes down to the surface's.
  EXPECT_EQ(after_start("G1 X70 Z-1\n"), "G1 X10 Z2.01\nG1 X70 Z-0.93\n");
  EXPECT_EQ(after_start("G0 Z5\nG1 X60 Z0\nG1 X10 Z5\n"),
            "G0 Z5\nG1 X40 Z2.04\nG1 X60 Z0.06\nG1 X40 Z2.04\nG1 X10 Z5\n");
  // Up to the safe height itself: along the surface, and then to where the program goes on.
  EXPECT_EQ(after_start("G1 Z-1\nX70 Z2\n"), "G1 Z-0.99\nX70 Z2.07\nG1 X70 Z2\n");
  EXPECT_THAT(after_start("G2 X20 Y20 I5 Z-1\n"), HasSubstr("an arc through the safe height"));
}

TEST(GcodeLeveller, KeepsHelices) {
  LevelOptions rough;
  rough.height_tolerance = um(50);
  EXPECT_EQ(after_start("G1 Z0\nG2 X10 Y20 I5 J0 Z-0.5\n", rough),
            "G1 Z0.01\nG2 X10 Y20 Z-0.49 I5 J0\n");
}

TEST(GcodeLeveller, KeepsTheDigitsThatMakeACircleFullOrNot) {
  const std::string start = "G21\nG0 Z2\nG0 X10 Y19.99996\n";
  EXPECT_EQ(levelled(start + "G1 Z-0.1\nG2 X10 Y19.99996 I0.05 J0\n", sloping_map()),
            start + "G1 Z-0.09\nG2 X10 Y19.99996 Z-0.09 I0.05 J0\n");
  EXPECT_EQ(levelled(start + "G1 Z-0.1\nG2 X10 Y20.00004 I0.05 J0\n", sloping_map()),
            start + "G1 Z-0.09\nG2 X10 Y20.00004 Z-0.09 I0.05 J0\n");
  const std::string inches = "G20\nG0 Z0.1\nG0 X1.1234567 Y0.7\nG1 Z-0.01\n";
  EXPECT_THAT(levelled(inches + "X1.0000001\n", sloping_map()), HasSubstr("\nX1.0000001 Z"));
}

TEST(GcodeLeveller, TellsOfMovesOverPlacesThatNobodyProbed) {
  std::vector<ProbePoint> points;
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 11; ++i) {
      if (i >= 4 && i <= 6 && j >= 4 && j <= 6) continue;
      points.push_back({position_mm<frame::Nominal>(10.0 * i, 10.0 * j), {mm(0.1), um(2)}, "", {}});
    }
  }
  const auto map = HeightMap::of_probes(points);
  ASSERT_TRUE(map);
  const auto done =
      level_gcode({"p.ngc", "G21\nG0 Z2\nX5 Y50\nG1 Z-0.1\nX95\nY95\nX103\nG0 Z2\n"}, *map);
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(done->figures.n_filled, 1);
  EXPECT_EQ(done->figures.n_extrapolated, 1);
}

TEST(GcodeLeveller, RefusesWhatWouldGoThroughTheBoard) {
  EXPECT_THAT(after_start("G1 Z-0.1\nX120\n"), HasSubstr("p.ngc:5:1: error[grid-invalid]"));
  EXPECT_THAT(after_start("G28\nG1 Z-0.1\n"),
              HasSubstr("p.ngc:5:1: error[coordinate-missing]: a move below the safe height"));
  EXPECT_THAT(after_start("M6 T1\nG1 Z-0.1\n"), HasSubstr("error[coordinate-missing]"));
  EXPECT_THAT(after_start("G43 H1\nG1 X20 Z-0.1\n"), HasSubstr("error[coordinate-missing]"));
  EXPECT_THAT(
      levelled("G21\nG1 X5 Y5\n", sloping_map(), {.safe_height = mm(2)}),
      HasSubstr("p.ngc:2:1: error[coordinate-missing]: a move at nobody knows what height"));
  EXPECT_THAT(after_start("G91 G1 Z-0.1\n"), HasSubstr("error[not-supported]"));
}

TEST(GcodeLeveller, RefusesASafeHeightThatTheBoardReaches) {
  EXPECT_THAT(
      levelled("G21\nG0 Z0.05\nG0 X1 Y1\nG1 Z-1\n", sloping_map()),
      HasSubstr("p.ngc: error[argument-invalid]: the program never moves in X or Y above the "
                "board, whose highest place is at 0.10"));
  EXPECT_THAT(
      after_start("G1 Z-0.1\nX60\n", {.safe_height = um(50)}),
      HasSubstr("p.ngc: error[argument-invalid]: a safe height of 0.050 mm, which the board "
                "reaches: it is up to 0.10"));
  EXPECT_THAT(after_start("G1 Z-0.1\n", {.height_tolerance = um(0)}),
              HasSubstr("error[argument-invalid]: a height tolerance of 0 or less"));
}

TEST(GcodeLeveller, RefusesAMapThatCountsFromTheTable) {
  const HeightMap map = probed_map([](double x, double) { return 1.6 + 1e-3 * x; }, 5);
  const std::string text = std::string(kStart) + "G1 Z-0.1\n";
  EXPECT_THAT(levelled(text, map), HasSubstr("so its 0 is not where the tool touches the board"));
  LevelOptions options;
  options.zero = position_mm<frame::Nominal>(10, 50);
  EXPECT_THAT(levelled(text, map, options), HasSubstr("\nG1 Z-0.1\n"));
}

TEST(GcodeLeveller, TakesAUnitThatNobodyStates) {
  LevelOptions options;
  options.unit_mm = 1;
  EXPECT_EQ(levelled("G0 Z2\nG0 X10 Y20\nG1 Z-0.1\n", sloping_map(), options),
            "G0 Z2\nG0 X10 Y20\nG1 Z-0.09\n");
}

/// How far the levelled program is off the surface at worst, and the program off its way.
struct Deviation {
  double height_mm = 0;
  double way_mm = 0;
  int n_moves = 0;
};

/// Follows the levelled program below z = 1; all its moves are at -0.1.
Deviation deviation(const std::string& text,
                    const std::function<double(const Eigen::Vector2d&)>& surface_mm) {
  gcode::MotionReader reader("levelled");
  LineCursor cursor(text);
  Deviation worst;
  while (!cursor.at_end()) {
    const auto block = gcode::read_gcode_block(cursor.next(), "levelled");
    EXPECT_TRUE(block);
    const auto read = reader.read(*block);
    EXPECT_TRUE(read) << read.error().text();
    if (!read || !*read || !(*read)->from.has_xy()) continue;
    const gcode::Motion& move = **read;
    if (*move.from.z_mm > 1 || *move.to.z_mm > 1) continue;
    ++worst.n_moves;
    const Eigen::Vector2d from_mm = move.from.xy_mm(), to_mm = move.to.xy_mm();
    const Eigen::Vector2d begin_mm = from_mm - move.center_mm;
    const double start_rad = std::atan2(begin_mm.y(), begin_mm.x());
    for (int i = 0; i <= 40; ++i) {
      const double t = i / 40.0, angle_rad = start_rad + t * move.sweep_rad;
      const Eigen::Vector2d at_mm =
          move.is_arc() ? Eigen::Vector2d(move.center_mm +
                                          begin_mm.norm() * Eigen::Vector2d(std::cos(angle_rad),
                                                                            std::sin(angle_rad)))
                        : Eigen::Vector2d(from_mm + t * (to_mm - from_mm));
      if (i == 40) worst.way_mm = std::max(worst.way_mm, (at_mm - to_mm).norm());
      const double z_mm = *move.from.z_mm + t * (*move.to.z_mm - *move.from.z_mm);
      worst.height_mm = std::max(worst.height_mm, std::abs(z_mm + 0.1 - surface_mm(at_mm)));
    }
  }
  return worst;
}

TEST(GcodeLeveller, KeepsToTheSurfaceOnLinesAndArcs) {
  const HeightMap map = probed_map([](double x, double y) {
    return 0.2 * std::sin(x / 15) * std::cos(y / 20) + 5e-5 * x * y / 10;
  });
  const auto surface_mm = [&](const Eigen::Vector2d& p_mm) {
    return map.height_at(position_mm<frame::Nominal>(p_mm))->height.in_mm();
  };
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double tolerance_um = std::pow(10, random.uniform(0.5, 1.7));
    std::string text = "G21\nG0 Z5\nG0 X50 Y50\nG1 Z-0.1 F200\n";
    for (int i = 0; i < 10; ++i) {
      if (random.uniform() < 0.5) {
        text += fmt::format("G1 X{:.3f} Y{:.3f}\n", random.uniform(0, 100), random.uniform(0, 100));
        continue;
      }
      const int sense = random.uniform() < 0.5 ? 2 : 3;
      const int end_mm = random.uniform() < 0.3 ? 50 : 80;  // round, or half round (65, 50)
      text += fmt::format("G1 X50 Y50\nG{} X{} Y50 I15 J0\n", sense, end_mm);
    }
    const auto done = level_gcode({"p.ngc", text}, map, {.height_tolerance = um(tolerance_um)});
    ASSERT_TRUE(done) << done.error().text();
    const Deviation worst = deviation(done->text, surface_mm);
    constexpr double kRounding_mm = 2e-4;
    EXPECT_LE(worst.height_mm, 1e-3 * tolerance_um + kRounding_mm);
    EXPECT_LE(worst.way_mm, kRounding_mm);
    EXPECT_EQ(worst.n_moves + 1, done->figures.n_pieces);
  }
}

}  // namespace
}  // namespace panelcal
