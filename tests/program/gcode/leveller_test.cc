// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/leveller.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <fmt/format.h>

#include "tests/program/gcode/gcode_text.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::levelled;
using test::probed_map;
using test::Reports;
using test::sloping_map;
using ::testing::HasSubstr;

constexpr std::string_view kStart = "G17 G21 G90 G91.1 G94 G98\nG0 Z2\nG0 X10 Y20\n";

/// Appended, not added: of a sum g++ 12 believes that it reads beyond its end.
std::string begun(std::string_view lines) {
  std::string text(kStart);
  text += lines;
  return text;
}

std::string after_start(const std::string& lines, const LevelOptions& options = {}) {
  const std::string text = levelled(begun(lines), sloping_map(), options);
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
  const std::string text = "G20 G90 G94\nG0 Z0.1\nG0 X1 Y1\nG1 Z-0.01\n";
  // 25.4 mm along the slope are 0.0254 mm, a thousandth of an inch.
  EXPECT_EQ(levelled(text, sloping_map()), "G20 G90 G94\nG0 Z0.1\nG0 X1 Y1\nG1 Z-0.009\n");
}

TEST(GcodeLeveller, GivesEveryHoleOfACycleItsOwnDepth) {
  EXPECT_EQ(after_start("G81 X20 Y20 Z-1 R0.5 F50\nX40\nG80\n"),
            "G81 F50 X20 Y20 Z-0.98 R0.52\nX40 Z-0.96 R0.54\nG80\n");
  EXPECT_THAT(after_start("G99 G81 X20 Y20 Z-1 R0.05\n"),
              Reports("p.ngc:4:1: error[not-supported]", "0.050 mm", "2.000"));
  LevelOptions low;
  low.safe_height = mm(0.5);
  EXPECT_EQ(after_start("G99 G81 X20 Y20 Z-1 R0.5\n", low), "G99 G81 X20 Y20 Z-0.98 R0.5\n");
}

TEST(GcodeLeveller, RefusesCyclesInSteps) {
  EXPECT_THAT(after_start("G91 G81 X20 Z-1 R-1\n"), HasSubstr("p.ngc:4:1: error[not-supported]"));
}

TEST(GcodeLeveller, KeepsVariablesThatLeadNowhere) {
  EXPECT_EQ(after_start("#1=100\nG1 Z-0.1 F#1\n"), "#1=100\nG1 F#1 Z-0.09\n");
}

TEST(GcodeLeveller, ACycleReturnsToWhereTheProgramHasIt) {
  // R is lifted by the board, but not above where the tool travels: it would stay there.
  EXPECT_EQ(after_start("G81 X20 Y20 Z-1 R1.99 F50\n"), "G81 F50 X20 Y20 Z-0.98 R2\n");
  // A bottom that the board lifts to R is no hole.
  EXPECT_THAT(after_start("G81 X20 Y20 Z1.985 R1.99 F50\n"),
              Reports("p.ngc:4:1: error[not-supported]", "2.005 mm", "2.000 mm"));
  // From 0.49 the tool returns to R; lifted to 0.5 or more it might return to there.
  LevelOptions low;
  low.safe_height = mm(0.5);
  EXPECT_EQ(after_start("G1 Z0.495\nG81 X20 Y20 Z-1 R0.5 F50\nG80\n", low),
            "G1 Z0.505\nG21 G90 G0 Z0.5\nG81 F50 X20 Y20 Z-0.98 R0.5\nG80\n");
  EXPECT_EQ(after_start("G20 G91 G1 Z-0.07\nG90 G82 X1 Y1 Z-0.05 R0.02 F50\n", low),
            "G20 G91 G1 Z-0.069606\nG20 G90 G0 Z0.019685\nG90 G82 F50 X1 Y1 Z-0.049 R0.02\n");
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
  const auto done = level_gcode({"p.ngc", begun("G1 Z-0.1\nX60\nG0 Z2\n")}, sloping_map());
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
      "G21 G90 G94\nG0 Z30\nX10 Y20\nG0 Z2\nX20\nG0 Z0.05\nX30\nG1 Z-0.1\nG0 Z30\nX500 Y500\n";
  EXPECT_EQ(levelled(text, sloping_map()),
            "G21 G90 G94\nG0 Z30\nX10 Y20\nG0 Z2\nX20\nG0 Z0.07\nX30 Z0.08\nG1 Z-0.07\nG0 "
            "Z30\nX500 Y500\n");
}

TEST(GcodeLeveller, TravelsOfCyclesCount) {
  // Rapid moves go to 0.25 inch and 1.5 inch only, between holes the tool is at 0.05 inch.
  EXPECT_EQ(
      levelled("G17 G20 G90 G94\nG0 Z0.25\nG0 X1 Y1\nG99 G82 X1 Y1 Z-0.05 R0.05 P1\nX2\n",
               sloping_map()),
      "G17 G20 G90 G94\nG0 Z0.25\nG0 X1 Y1\nG99 G82 P1 X1 Y1 Z-0.049 R0.05\nX2 Z-0.048 R0.05\n");
  EXPECT_THAT(levelled("G21\nG1 Z3 F9\nX10 Y10\nZ-0.1\n", sloping_map()), HasSubstr("\nZ-0.09\n"));
}

TEST(GcodeLeveller, CutsRampsAtTheSafeHeight) {
  // From 2 (safe) to -1 over 60 mm. At the safe height the tool goes down to the surface's.
  EXPECT_EQ(after_start("G1 X70 Z-1\n"), "G1 X10 Z2.01\nG1 X70 Z-0.93\n");
  EXPECT_EQ(after_start("G0 Z5\nG1 X60 Z0\nG1 X10 Z5\n"),
            "G0 Z5\nG1 X40 Z2.04\nG1 X60 Z0.06\nG1 X40 Z2.04\nG1 X10 Z5\n");
  // Up to the safe height itself: along the surface, and then to where the program goes on.
  EXPECT_EQ(after_start("G1 Z-1\nX70 Z2\n"), "G1 Z-0.99\nX70 Z2.07\nG1 X70 Z2\n");
}

TEST(GcodeLeveller, SinksToALowerBoardAtTheSafeHeightAndNotOnItsWayThere) {
  // Spread over the way from X10 to X40 the tool would sink towards what may stand higher there.
  const HeightMap map = probed_map([](double x, double) { return -1e-3 * x; });
  EXPECT_EQ(levelled(begun("G0 Z5\nG1 X60 Z0\nG1 X10 Z5\n"), map),
            begun("G0 Z5\nG1 X40 Z2\nG1 X40 Z1.96\nG1 X60 Z-0.06\nG1 X40 Z1.96\nG1 X40 Z2\n"
                  "G1 X10 Z5\n"));
  // At the safe height itself: straight down, or on an arc's first hundredth of a millimetre.
  EXPECT_EQ(levelled(begun("G1 X60 Z0\n"), map), begun("G1 X10 Z1.99\nG1 X60 Z-0.06\n"));
  LevelOptions rough;
  rough.height_tolerance = um(50);
  EXPECT_EQ(levelled(begun("G0 Z3\nG2 X30 Y20 I10 J0 Z1\nG0 Z2\n"), map, rough),
            begun("G0 Z3\nG2 X20 Y30 Z2 I10 J0\nG2 X20.01 Y29.999995 Z1.9794 I0 J-10\n"
                  "G2 X30 Y20 Z0.97 I-0.01 J-9.999995\nG0 Z2\n"));
  EXPECT_EQ(levelled(begun("G1 Z1\nG3 X30 Y20 I10 J0 Z3\n"), map, rough),
            begun("G1 Z0.99\nG3 X20 Y10 Z1.98 I10 J0\nG3 X20.01 Y10.000005 Z2.0006 I0 J10\n"
                  "G3 X30 Y20 Z3 I-0.01 J9.999995\n"));
}

TEST(GcodeLeveller, CutsHelicesAtTheSafeHeight) {
  LevelOptions rough;
  rough.height_tolerance = um(50);
  // Half a circle about (20, 20), from 3 at (10, 20) to 1 at (30, 20): through 2 at (20, 30).
  EXPECT_EQ(after_start("G0 Z3\nG2 X30 Y20 I10 J0 Z1\nG0 Z2\n", rough),
            "G0 Z3\nG2 X20 Y30 Z2.02 I10 J0\nG2 X30 Y20 Z1.03 I0 J-10\nG0 Z2\n");
  EXPECT_EQ(after_start("G1 Z1\nG3 X30 Y20 I10 J0 Z3\n", rough),
            "G1 Z1.01\nG3 X20 Y10 Z2.02 I10 J0\nG3 X30 Y20 Z3 I0 J10\n");
}

TEST(GcodeLeveller, AnArcHasNoPieceWithoutLength) {
  LevelOptions rough;
  rough.height_tolerance = um(50);
  // It begins at the safe height itself: no full circle is added, which would have no end.
  const std::string text = begun("G2 X30 Y20 I10 J0 Z-1\nG2 X10 Y20 I-10 J0 Z2\n");
  const auto done = level_gcode({"p.ngc", text}, sloping_map(), rough);
  ASSERT_TRUE(done) << done.error().text();
  gcode::MotionReader reader("levelled");
  LineCursor cursor(done->text);
  double turned_rad = 0;
  while (!cursor.at_end()) {
    const auto motion = reader.read(*gcode::read_gcode_block(cursor.next(), "levelled"));
    ASSERT_TRUE(motion);
    if (*motion) turned_rad += (*motion)->sweep_rad;
  }
  EXPECT_NEAR(turned_rad, -2 * std::numbers::pi, 1e-6);
  // Shorter than any piece: it ends where the program has it.
  EXPECT_EQ(after_start("G2 X10.01 Y20 I0.005 J0 Z1\n", rough), "G2 X10.01 Y20 Z1.01 I0.005 J0\n");
}

TEST(GcodeLeveller, StepsLeadToTheSurface) {
  EXPECT_EQ(after_start("G91\nG1 Z-2.1 F100\nX50\nY1\nG0 Z2.1\nX5\nG90\nG1 Z-0.1\n"),
            "G91\nG1 F100 Z-2.09\nX50 Z0.05\nY1 Z0\nG0 Z2.04\nX5\nG90\nG1 Z-0.035\n");
  // Cut at the safe height, as without G91.
  EXPECT_EQ(after_start("G91 G1 X60 Z-3\n"), "G91 G1 X0 Z0.01\nG1 X60 Z-2.94\n");
  EXPECT_THAT(after_start("G91 G28 Z0\nG1 Z-1\n"),
              HasSubstr("p.ngc:5:1: error[coordinate-missing]"));
}

TEST(GcodeLeveller, KeepsHelices) {
  LevelOptions rough;
  rough.height_tolerance = um(50);
  EXPECT_EQ(after_start("G1 Z0\nG2 X10 Y20 I5 J0 Z-0.5\n", rough),
            "G1 Z0.01\nG2 X10 Y20 Z-0.49 I5 J0\n");
}

TEST(GcodeLeveller, KeepsTheDigitsThatMakeACircleFullOrNot) {
  const std::string start = "G17 G21 G90 G91.1 G94\nG0 Z2\nG0 X10 Y19.99996\n";
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
  EXPECT_THAT(after_start("G28\nG1 Z-0.1\n"), HasSubstr("p.ngc:5:1: error[coordinate-missing]"));
  EXPECT_THAT(after_start("M6 T1\nG1 Z-0.1\n"), HasSubstr("error[coordinate-missing]"));
  EXPECT_THAT(after_start("G43 H1\nG1 X20 Z-0.1\n"), HasSubstr("error[coordinate-missing]"));
  EXPECT_THAT(levelled("G21\nG1 X5 Y5\n", sloping_map(), {.safe_height = mm(2)}),
              HasSubstr("p.ngc:2:1: error[coordinate-missing]"));
  EXPECT_THAT(after_start("G91 G81 X1 Z-0.1 R1\n"), HasSubstr("error[not-supported]"));
}

TEST(GcodeLeveller, RefusesASafeHeightThatTheBoardReaches) {
  EXPECT_THAT(levelled("G21\nG0 Z0.05\nG0 X1 Y1\nG1 Z-1\n", sloping_map()),
              Reports("p.ngc: error[argument-invalid]", "0.10"));
  EXPECT_THAT(after_start("G1 Z-0.1\nX60\n", {.safe_height = um(50)}),
              Reports("p.ngc: error[argument-invalid]", "0.050 mm", "0.10"));
  EXPECT_THAT(after_start("G1 Z-0.1\n", {.height_tolerance = um(0)}),
              HasSubstr("error[argument-invalid]"));
}

TEST(GcodeLeveller, RefusesAMapThatCountsFromTheTable) {
  const HeightMap map = probed_map([](double x, double) { return 1.6 + 1e-3 * x; }, 5);
  const std::string text = begun("G1 Z-0.1\n");
  EXPECT_THAT(levelled(text, map), Reports("p.ngc: error[argument-invalid]"));
  LevelOptions options;
  options.zero = position_mm<frame::Nominal>(10, 50);
  EXPECT_THAT(levelled(text, map, options), HasSubstr("\nG1 Z-0.1\n"));
}

TEST(GcodeLeveller, TakesAUnitThatNobodyStates) {
  LevelOptions options;
  options.unit_mm = 1;
  EXPECT_EQ(levelled("G90 G94\nG0 Z2\nG0 X10 Y20\nG1 Z-0.1\n", sloping_map(), options),
            "G90 G94\nG21 (not stated by the program)\nG0 Z2\nG0 X10 Y20\nG1 Z-0.09\n");
  options.unit_mm = 25.4;
  EXPECT_THAT(levelled("G90\nG0 Z2\nG0 X1 Y2\n", sloping_map(), options),
              HasSubstr("G20 (not stated by the program)\nG0 Z2\n"));
}

TEST(GcodeLeveller, WritesTheModesThatTheProgramReliesOnWhereItFirstDoes) {
  EXPECT_EQ(levelled("G21\nG0 Z2\nG0 X10 Y20\nG81 X20 Y20 Z-1 R0.5 F50\nX40\nG80\nG0 Z2\n",
                     sloping_map()),
            "G21\nG90 (not stated by the program)\nG0 Z2\nG0 X10 Y20\n"
            "G17 G94 G98 (not stated by the program)\nG81 F50 X20 Y20 Z-0.98 R0.52\nX40 Z-0.96 "
            "R0.54\nG80\nG0 Z2\n");
  LevelOptions rough;
  rough.height_tolerance = um(20);
  EXPECT_EQ(levelled("G21 G90\nG0 Z2\nG0 X10 Y20\nG1 Z-0.1 F9\nG2 X20 Y20 I5 J0\nG0 Z2\n",
                     sloping_map(),
                     rough),
            "G21 G90\nG0 Z2\nG0 X10 Y20\nG94 (not stated by the program)\nG1 F9 Z-0.09\nG17 G91.1 "
            "(not stated by the program)\nG2 X20 Y20 Z-0.08 I5 J0\nG0 Z2\n");
  // A feed counts in what is in force where it stands; G94 sets it to 0.
  EXPECT_EQ(levelled("G90\nF9 M3\nG0 Z2\nG0 X10 Y20 F8\nG1 Z-0.1\n", sloping_map(), {.unit_mm = 1}),
            "G90\nG21 G94 (not stated by the program)\nF9 M3\nG0 Z2\nG0 X10 Y20 F8\nG1 Z-0.09\n");
  EXPECT_EQ(levelled("F9\nG21 G90\nG0 Z2\nG0 X10 Y20\n", sloping_map()),
            "G94 (not stated by the program)\nF9\nG21 G90\nG0 Z2\nG0 X10 Y20\n");
  // The first move's own block may state them.
  EXPECT_EQ(levelled("G21 G90 G0 Z2\nX10 Y20\n", sloping_map(), {.safe_height = mm(2)}),
            "G21 G90 G0 Z2\nX10 Y20\n");
}

TEST(GcodeLeveller, PutsALongCommentIntoALineOfItsOwn) {
  const std::string comment = "(" + std::string(248, 'c') + ")";
  EXPECT_EQ(after_start("G1 Z-0.1 F100\nX60 " + comment + "\n"),
            "G1 F100 Z-0.09\n" + comment + "\nX60 Z-0.04\n");
  // LinuxCNC reads 252 characters.
  const std::string fits = "(" + std::string(239, 'c') + ")",
                    longer = "(" + std::string(240, 'c') + ")";
  EXPECT_EQ(after_start("G1 Z-0.1\nX60" + fits + "\nX50" + longer + "\n"),
            "G1 Z-0.09\nX60 Z-0.04 " + fits + "\n" + longer + "\nX50 Z-0.05\n");
}

/// LinuxCNC stops at a line of more than 252 characters, be it a comment.
TEST(GcodeLeveller, SplitsWhatIsTooLongForALine) {
  const auto c = [](std::size_t n) { return std::string(n, 'c'); };
  EXPECT_EQ(after_start("(" + c(251) + ")\n;" + c(252) + "\n"),
            "(" + c(250) + ")\n(... c)\n;" + c(251) + "\n;... c\n");
  // Of an order to the control the first line is left, and stands before its block.
  EXPECT_EQ(after_start("M3 S9 (MSG," + c(500) + ")(b)\n"),
            "(MSG," + c(246) + ")\n(... " + c(246) + ")\n(... " + c(8) + ")\n(b)\nM3 S9\n");
  EXPECT_EQ(after_start("/N5 (" + c(250) + ")\n"), "/(" + c(249) + ")\n/(... c)\n/N5\n");
  EXPECT_EQ(after_start("M3" + std::string(260, ' ') + "S9 (b)\n"), "(b)\nM3 S9\n");
  EXPECT_EQ(after_start("G1 Z-0.1\nX60 (" + c(251) + ")\n"),
            "G1 Z-0.09\n(" + c(250) + ")\n(... c)\nX60 Z-0.04\n");
  // No character is cut in two.
  EXPECT_EQ(after_start("(" + c(249) + "\u00b5m" + c(20) + ")\n"),
            "(" + c(249) + ")\n(... \u00b5m" + c(20) + ")\n");
}

/// Greatest distance of the levelled program from the surface, and of the program from its way.
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
    constexpr double kPrinted_mm = 2e-4;
    EXPECT_LE(worst.height_mm, 1e-3 * tolerance_um + kPrinted_mm);
    EXPECT_LE(worst.way_mm, kPrinted_mm);
    EXPECT_EQ(worst.n_moves + 1, done->figures.n_pieces);
  }
}

/// Ends of all moves.
std::vector<Eigen::Vector3d> ends_mm(const std::string& text) {
  gcode::MotionReader reader("levelled");
  LineCursor cursor(text);
  std::vector<Eigen::Vector3d> ends;
  while (!cursor.at_end()) {
    const auto motion = reader.read(*gcode::read_gcode_block(cursor.next(), "levelled"));
    EXPECT_TRUE(motion) << motion.error().text();
    if (!motion || !*motion || !(*motion)->to.has_xy() || !(*motion)->to.z_mm) continue;
    ends.emplace_back(*(*motion)->to.x_mm, *(*motion)->to.y_mm, *(*motion)->to.z_mm);
  }
  return ends;
}

/// A program in G90 and the same in G91, of lines and arcs below, above and through the safe
/// height.
struct Spellings {
  std::string places = "G21\nG0 X50 Y50 Z2\n";
  std::string steps = places + "G91\n";
};

Spellings random_program(Random& random) {
  Spellings text;
  Eigen::Vector3d at_mm(50, 50, 2);
  const auto round = [](double value_mm) { return std::round(1000 * value_mm) / 1000; };
  for (int i = 0; i < 60; ++i) {
    Eigen::Vector3d to_mm(round(random.uniform(5, 95)),
                          round(random.uniform(5, 95)),
                          random.uniform() < 0.4 ? 2 : round(random.uniform(-1, 3)));
    std::string code = random.uniform() < 0.3 ? "G0" : "G1", center;
    if (random.uniform() < 0.4) {  // half a circle to the left or to the right, inside of the map
      code = random.uniform() < 0.5 ? "G2" : "G3";
      const double half_mm = round(random.uniform(-20, 20));
      const double middle_mm = std::clamp(at_mm.x(), 25.0, 75.0);
      to_mm.x() = round(at_mm.x() + 2 * (at_mm.x() > middle_mm ? -std::abs(half_mm) : half_mm));
      to_mm.y() = at_mm.y();
      if (at_mm.y() < 25 || at_mm.y() > 75 || to_mm.x() < 1 || to_mm.x() > 99 || half_mm == 0) {
        continue;
      }
      center = fmt::format(" I{:.4f} J0", (to_mm.x() - at_mm.x()) / 2);
    }
    const Eigen::Vector3d step_mm = to_mm - at_mm;
    const std::string words = "{} X{:.3f} Y{:.3f} Z{:.3f}{}\n";
    text.places += fmt::format(fmt::runtime(words), code, to_mm.x(), to_mm.y(), to_mm.z(), center);
    text.steps +=
        fmt::format(fmt::runtime(words), code, step_mm.x(), step_mm.y(), step_mm.z(), center);
    at_mm = to_mm;
  }
  return text;
}

TEST(GcodeLeveller, StepsLeadWherePlacesDo) {
  const HeightMap map =
      probed_map([](double x, double y) { return 0.2 * std::sin(x / 15) * std::cos(y / 20); });
  // The last digits of heights and places; steps do not add their rounding up.
  constexpr double kPrinted_mm = 1.1e-4;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Spellings program = random_program(random);
    const LevelOptions options{.height_tolerance = um(15), .safe_height = mm(2)};
    const auto places = level_gcode({"places.ngc", program.places}, map, options);
    const auto steps = level_gcode({"steps.ngc", program.steps}, map, options);
    ASSERT_TRUE(places) << places.error().text() << program.places;
    ASSERT_TRUE(steps) << steps.error().text();
    const auto a_mm = ends_mm(places->text), b_mm = ends_mm(steps->text);
    ASSERT_EQ(a_mm.size(), b_mm.size());
    ASSERT_GT(a_mm.size(), 30u);
    for (std::size_t i = 0; i < a_mm.size(); ++i) {
      EXPECT_LT((a_mm[i] - b_mm[i]).lpNorm<Eigen::Infinity>(), kPrinted_mm) << "move " << i;
    }
  }
}

}  // namespace
}  // namespace panelcal
