// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/mover.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/gcode/board_places.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::AffinePlaces;
using test::stretched;
using test::turned;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::string_view kStart = "G17 G21 G90 G91.1 G94 G98\nG0 Z2\nG0 X10 Y20\n";

std::string moved(const std::string& text,
                  const BoardPlaces& places,
                  const MoveOptions& options = {}) {
  const auto done = move_gcode({"p.ngc", text}, places, options);
  return done ? done->text : test::brief(done.error());
}

/// What becomes of lines behind a move to (10, 20), which is at (80, 10) of the turned board.
std::string after_start(const std::string& lines, const BoardPlaces& places = turned()) {
  std::string text(kStart);
  text += lines;
  const std::string out = moved(text, places);
  const std::size_t n_lines = 3;
  std::size_t at = 0;
  for (std::size_t i = 0; i < n_lines && out.starts_with("G17"); ++i) at = out.find('\n', at) + 1;
  return out.substr(at);
}

TEST(GcodeMover, WritesBothAxesWhereEitherStood) {
  EXPECT_EQ(moved(std::string(kStart), turned()), "G17 G21 G90 G91.1 G94 G98\nG0 Z2\nG0 X80 Y10\n");
  EXPECT_EQ(after_start("G1 X11 F100\nY21\nZ-1\n"), "G1 F100 X80 Y11\nX79 Y11\nZ-1\n");
}

TEST(GcodeMover, LeavesAloneWhatIsNoMoveInXAndY) {
  const std::string text =
      "%\n(a board)\nG21 (mm)\nG90 G94\n\nM3 S20000\nG00 Z2.000\nG4 P1\nT1 M6\nF100\nG1 Z-.1\n"
      "M5 ;off\nM2\n(the end)\n%\n";
  EXPECT_EQ(moved(text, turned()), text);
}

TEST(GcodeMover, KeepsOtherWordsHeightsAndComments) {
  EXPECT_EQ(after_start("N5 g01 X10 Z-0.100 F100 M8 (down)\nN6 X20 M2 ;end\n"),
            "N5 g01 F100 M8 X80 Y10 Z-0.100 (down)\nN6 X80 Y20 M2 ;end\n");
}

TEST(GcodeMover, CountsInTheProgramsUnit) {
  EXPECT_EQ(moved("G20 G90 G94\nG0 X1 Y2\nG21\nG0 X25.4\n", turned()),
            "G20 G90 G94\nG0 X1.937008 Y1\nG21\nG0 X49.2 Y25.4\n");
}

TEST(GcodeMover, KeepsArcsOfASimilarity) {
  EXPECT_EQ(after_start("G2 X20 Y30 I10 J0 F100\n"), "G2 F100 X70 Y20 I0 J10\n");
  EXPECT_EQ(after_start("G3 X20 Y30 R10\n"), "G3 X70 Y20 I-10 J0\n");
  EXPECT_EQ(after_start("G2 I5\n"), "G2 X80 Y10 I0 J5\n");
  EXPECT_EQ(after_start("G90.1\nG2 X20 Y30 I20 J20 Z-1\n"), "G90.1\nG2 X70 Y20 Z-1 I80 J20\n");
}

TEST(GcodeMover, AMirrorTurnsTheSenseOfArcs) {
  const AffinePlaces mirrored((Eigen::Matrix2d() << -1, 0, 0, 1).finished(), {0, 0});
  EXPECT_EQ(after_start("G2 X20 Y30 I10 J0\nX30 Y40 I10 J0\nG1 X0\nG3 Y50 R5\n", mirrored),
            "G3 X-20 Y30 I-10 J0\nX-30 Y40 I-10 J0\nG1 X0 Y40\nG2 X0 Y50 I0 J5\n");
  // The word alone is written as it is, so the next arc states its own.
  EXPECT_EQ(after_start("G2 X20 Y30 I10 J0\nG2\nX30 Y40 I10 J0\nX40 Y50 I10 J0\n", mirrored),
            "G3 X-20 Y30 I-10 J0\nG2\nG3 X-30 Y40 I-10 J0\nX-40 Y50 I-10 J0\n");
}

// A circle of 10 mm becomes an ellipse of 10.1 by 10 mm.
TEST(GcodeMover, CutsArcsThatBecomeEllipses) {
  const std::string circle = after_start("G2 I10 Z-0.8 F100\nG1 X0\n", stretched());
  EXPECT_THAT(circle, StartsWith("G2 F100 X"));
  EXPECT_GT(std::ranges::count(circle, '\n'), 8);
  EXPECT_THAT(circle, HasSubstr("\nG2 X10.1 Y20 Z-0.8 I"));
  EXPECT_THAT(circle, ::testing::EndsWith("\nG1 X0 Y20\n"));
  MoveOptions wide;
  wide.tolerance = um(120);
  EXPECT_EQ(moved("G21 G90 G94 G17 G91.1\nG0 X10 Y20\nG2 I10\n", stretched(), wide),
            "G21 G90 G94 G17 G91.1\nG0 X10.1 Y20\nG2 X10.1 Y20 I10.1 J0\n");
  wide.tolerance = um(0);
  EXPECT_EQ(moved("", stretched(), wide), "p.ngc: error[argument-invalid]");
}

TEST(GcodeMover, CutsLinesOfABentBoard) {
  const std::string lines = moved("G21 G90 G94\nG0 X0 Y0 Z0\nG1 X100 Z-1\n", test::BentPlaces());
  // A chord over s mm deviates by 1e-4 s^2 / 4: 8.9 mm for 2 um, so 12 pieces.
  EXPECT_EQ(std::ranges::count(lines, '\n'), 2 + 12);
  EXPECT_THAT(lines, HasSubstr("\nG1 X50 Y0.25 Z-0.5\n"));
  EXPECT_THAT(lines, HasSubstr("\nG1 X100 Y1 Z-1\n"));
  EXPECT_EQ(moved("G21 G90 G94\nG0 X0 Y0\nG1 X100 Z-1\n", test::BentPlaces()),
            "p.ngc:3:9: error[coordinate-missing]");
}

TEST(GcodeMover, LeadsStepsFromActualPlaceToActualPlace) {
  EXPECT_EQ(after_start("G91 G1 X1 F100\nY-2\nX0.5 Z-1\nG90 X0\n"),
            "G91 G1 F100 X0 Y1\nX2 Y0\nX0 Y0.5 Z-1\nG90 X82 Y0\n");
  EXPECT_EQ(moved("G21 G90\nG91 G0 X1\n", turned()), "p.ngc:2:1: error[coordinate-missing]");
}

TEST(GcodeMover, MovesHolesAndKeepsTheirHeights) {
  EXPECT_EQ(after_start("G99 G81 X1 Y2 Z-1.80 R.5 F50\nX3\nG98 G83 Y4 Z-2 R1 Q0.5\nG80\n"),
            "G99 G81 F50 X98 Y1 Z-1.80 R.5\nX98 Y3\nG98 G83 Q0.5 X96 Y3 Z-2 R1\nG80\n");
  EXPECT_EQ(after_start("G81 Z-1 R1\n"), "G81 Z-1 R1\n");
  EXPECT_EQ(after_start("G91 G82 X1 Z-2 R-1 P1\nX1\n"), "G91 G82 P1 X0 Y1 Z-2 R-1\nX0 Y1\n");
}

TEST(GcodeMover, NeedsBothCoordinatesFirst) {
  EXPECT_EQ(moved("G21 G90\nG0 X1\n", turned()), "p.ngc:2:1: error[coordinate-missing]");
  EXPECT_EQ(moved("G21 G90\nG0 X1 Y1\nM6\nY1\n", turned()), "p.ngc:4:1: error[coordinate-missing]");
  EXPECT_EQ(moved("G90\nG0 X1 Y1\n", turned()), "p.ngc:2:1: error[argument-invalid]");
}

TEST(GcodeMover, LeavesMovesOfTheMachineAndKnowsWhatTheyLeave) {
  const auto done =
      move_gcode({"p.ngc", "G21 G90 G0 X1 Y2\nG53 G0 Z0\nX3\nG53 G0 X0\nG0 X4\nG28\n"}, turned());
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(done->text, "G21 G90 G0 X98 Y1\nG53 G0 Z0\nX98 Y3\nG53 G0 X0\nG0 X98 Y4\nG28\n");
  EXPECT_EQ(done->figures.n_left, 3);
  EXPECT_EQ(moved("G21 G90 G0 X1 Y2\nG28\nG91 X1\n", turned()),
            "p.ngc:3:1: error[coordinate-missing]");
}

// The tool stands at (10, 20), which is at (80, 10).
TEST(GcodeMover, CountsFromZerosThatTheProgramSets) {
  EXPECT_EQ(after_start("G92 X0 Y0\nG0 X1\nG92.1\nG0 X10\n"),
            "G92 X0 Y0\nG0 X0 Y1\nG92.1\nG0 X80 Y10\n");
  EXPECT_EQ(after_start("G92 X5\nG0 X6\n"), "G92 X5\nG0 X5 Y11\n");
  // (8, 20) of the new zero is (11, 20) of the board, at (80, 11).
  EXPECT_EQ(after_start("G52 X3\nG0 X8\nG52 X0\nG0 X8\n"),
            "G52 X3\nG0 X77 Y11\nG52 X0\nG0 X80 Y8\n");
  EXPECT_EQ(after_start("G92 X0 Y0\nG90.1 G2 X10 Y10 R10\n"),
            "G92 X0 Y0\nG90.1 G2 X-10 Y10 I0 J10\n");
  EXPECT_EQ(after_start("G92 X0 G1 Y5\n"), "p.ngc:4:8: error[not-supported]");
  EXPECT_EQ(after_start("G92.3\n"), "p.ngc:4:1: error[not-supported]");
  EXPECT_EQ(moved("G21 G90\nG92 X0 Y0\n", turned()), "p.ngc:2:5: error[coordinate-missing]");
}

TEST(GcodeMover, WritesSubprogramsOutWhereTheyAreCalled) {
  EXPECT_EQ(after_start("o1 sub\nG91 G0 X1\nG90\no1 endsub\no1 call\no<a> repeat [2]\no1 call\n"
                        "o<a> endrepeat (done)\n"),
            "(written out: o1 sub)\n"
            "(written out: o1 call)\nG91 G0 X0 Y1\nG90\n(written out: o1 endsub)\n"
            "(written out: o<a> repeat [2])\n"
            "(written out: o1 call)\nG91 G0 X0 Y1\nG90\n(written out: o1 endsub)\n"
            "(written out: o<a> endrepeat [done])\n"
            "(written out: o1 call)\nG91 G0 X0 Y1\nG90\n(written out: o1 endsub)\n"
            "(written out: o<a> endrepeat [done])\n");
  EXPECT_EQ(after_start("o1 sub\nG1 X1 F#1\no1 endsub\no1 call\n"),
            "p.ngc:5:7: error[not-supported]");
}

TEST(GcodeMover, KeepsVariablesThatLeadNowhere) {
  EXPECT_EQ(after_start("#1=100\n#<depth>=-1\nG1 X11 F[#1*2]\nM3 S#<_speed>\n"),
            "#1=100\n#<depth>=-1\nG1 F[#1*2] X80 Y11\nM3 S#<_speed>\n");
  for (const std::string_view line : {"G1 X#1", "G1 X1 Z#<depth>", "G1 Y[1+2]", "G#1 X1"}) {
    EXPECT_THAT(after_start(std::string(line)), HasSubstr("error[not-supported]")) << line;
  }
}

TEST(GcodeMover, RefusesWhatItCannotFollow) {
  for (const std::string_view line : {"G18 G2 X1 Z1 R1",
                                      "G10 L2 P1 X0",
                                      "G41 D1",
                                      "G55",
                                      "A90",
                                      "/G1 X1",
                                      "G38.2 Z-1",
                                      "G5.1 X1 I1",
                                      "M98 P1",
                                      "M72",
                                      "G81 X1 Z-1 R1 L2"}) {
    EXPECT_THAT(after_start(std::string(line)),
                testing::AllOf(StartsWith("p.ngc:4:"), HasSubstr("error[not-supported]")))
        << line;
  }
}

TEST(GcodeMover, StatesModalWordsThatTheProgramDoesNot) {
  EXPECT_EQ(moved("G21\nG0 X1 Y2\nG2 X3 Y4 R2 F100\n", turned()),
            "G21\nG90 (not stated by the program)\nG0 X98 Y1\n"
            "G17 G91.1 G94 (not stated by the program)\nG2 F100 X96 Y3 I0 J2\n");
  MoveOptions inches;
  inches.unit_mm = 25.4;
  EXPECT_EQ(moved("G90 G0 X0 Y1\n", turned(), inches),
            "G20 (not stated by the program)\nG90 G0 X2.937008 Y0\n");
}

TEST(GcodeMover, TellsWhereItWorksAndHowSureThatIs) {
  const auto done = move_gcode(
      {"p.ngc", "G21 G90 G94\nG0 X90 Y90\nX30 Y40\nG1 Z-1\nX0\nG0 Z2\nX90 Y90\n"}, turned());
  ASSERT_TRUE(done) << done.error().text();
  const MoveFigures& figures = done->figures;
  EXPECT_EQ(figures.n_moves, 6);
  EXPECT_EQ(figures.n_moved, 4);
  EXPECT_EQ(figures.n_pieces, 4);
  EXPECT_EQ(figures.nominal.low().in_mm(), Eigen::Vector2d(0, 40));
  EXPECT_EQ(figures.nominal.high().in_mm(), Eigen::Vector2d(30, 40));
  EXPECT_EQ(figures.actual.low().in_mm(), Eigen::Vector2d(60, 0));
  EXPECT_EQ(figures.actual.high().in_mm(), Eigen::Vector2d(60, 30));
  EXPECT_NEAR(figures.largest_sigma.in_um(), 6, 1e-9);
  EXPECT_EQ(figures.line_of_largest_sigma, 4);
  EXPECT_NEAR(figures.largest_shift.in_mm(), std::hypot(60.0, 40.0), 1e-9);
}

/// Beyond x = 50 mm the table ends.
class SmallTable final : public BoardPlaces {
 public:
  Eigen::Vector2d actual_mm(const Eigen::Vector2d& p_mm) const override { return p_mm; }
  Expected<Length> sigma(const Eigen::Vector2d& p_mm) const override {
    if (p_mm.x() > 50)
      return failure({Code::TravelExceeded, {}, "beyond the table", "a place on it"});
    return um(2);
  }
};

TEST(GcodeMover, RefusesWorkWhereTheMachineCannotGo) {
  const std::string text = "G21 G90 G94\nG0 X60 Y0\nG0 X40\n";
  EXPECT_EQ(moved(text, SmallTable()), "G21 G90 G94\nG0 X60 Y0\nG0 X40 Y0\n");
  EXPECT_EQ(moved(text + "G1 X60\n", SmallTable()), "p.ngc:4:1: error[travel-exceeded]");
  EXPECT_EQ(moved(text + "G2 X40 I8\n", SmallTable()), "p.ngc:4:1: error[travel-exceeded]");
}

TEST(GcodeMover, TellsWhichLineEachLineWasMadeOf) {
  const auto done =
      move_gcode({"p.ngc", "G21 G94\no1 sub\nG0 X1 Y1\no1 endsub\no1 call\n"}, turned());
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_THAT(done->source_lines, ElementsAre(1, 2, 5, 3, 3, 4)) << done->text;
}

}  // namespace
}  // namespace panelcal
