// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode/flavour.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/gcode/writer_run.h"

namespace panelcal {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

GcodeSetting of(GcodeFlavour flavour) {
  GcodeSetting setting = on_the_board();
  setting.flavour = flavour;
  setting.rapid = mm_per_s(50);
  return setting;
}

std::string text_of(const std::vector<What>& operations, const GcodeSetting& setting) {
  const Written written = write_out(operations, setting);
  EXPECT_THAT(written.failure, IsEmpty());
  EXPECT_THAT(written.losses, IsEmpty());
  return written.text;
}

std::size_t longest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
  return longest;
}

TEST(GcodeFlavour, HasANameAndIsFoundByIt) {
  for (const auto flavour : {GcodeFlavour::LinuxCnc, GcodeFlavour::Grbl, GcodeFlavour::Marlin}) {
    EXPECT_EQ(gcode_flavour_from_name(name(flavour)), flavour);
  }
  EXPECT_EQ(gcode_flavour_from_name("mach3"), std::nullopt);
}

TEST(GcodeFlavour, GrblGetsMovesAndIsAskedForTools) {
  EXPECT_EQ(
      text_of({take(1), drill(1, 10, 20), drill(1, -1.5, 0), Stop{StopKind::EndRewind, {}, {}}},
              of(GcodeFlavour::Grbl)),
      "G17 G21 G40 G54 G61 G80 G90 G91.1 G94\n"
      "(MSG, tool T1, 1 mm)\nM0\n"
      "S30000 M3\n"
      "G0 Z5\nG0 X10 Y20\nG1 Z-1.8 F1200\nG0 Z5\n"
      "G0 X-1.5 Y0\nG1 Z-1.8\nG0 Z5\n"
      "M5\nM2\n");
}

TEST(GcodeFlavour, MarlinGetsOneCommandALineWithTheFeedOfItsRapidMoves) {
  GcodeSetting setting = of(GcodeFlavour::Marlin);
  setting.spin_up = seconds(2.5);
  EXPECT_EQ(text_of({take(1), drill(1, 10, 20), Stop{StopKind::EndRewind, {}, {}}}, setting),
            "G21\nG90\n"
            "M117 tool T1, 1 mm\nM0\n"
            "M3 S30000\nG4 S2.5\n"
            "G0 Z5 F3000\nG0 X10 Y20\nG1 Z-1.8 F1200\nG0 Z5 F3000\n"
            "M5\n");
}

TEST(GcodeFlavour, MarlinIsToldTheFeedOfRapidMovesAgainBehindAPause) {
  const std::string text = text_of({take(1), drill(1, 10, 20), Message{"look"}, drill(1, 11, 20)},
                                   of(GcodeFlavour::Marlin));
  EXPECT_THAT(text, HasSubstr("M117 look\nM5\nM0\nM3 S30000\nG0 X11 Y20 F3000\n"));
}

TEST(GcodeFlavour, PecksByMovesWhereThereAreNoCycles) {
  GcodeSetting setting = of(GcodeFlavour::Grbl);
  setting.approach_z = mm(0.5);
  setting.usual.peck = mm(1);
  // G83 goes out of the hole, and back to a clearance above its bottom; G73 up by the clearance.
  EXPECT_THAT(text_of({take(1), function(FunctionKind::PeckOn, "M62"), drill(1, 1, 2)}, setting),
              HasSubstr("G0 X1 Y2\nG0 Z0.5\nG1 Z-0.5 F1200\nG0 Z0.5\nG0 Z-0.246\nG1 Z-1.5\n"
                        "G0 Z0.5\nG0 Z-1.246\nG1 Z-1.8\nG0 Z5\nM5\n"));
  EXPECT_THAT(text_of({take(1), function(FunctionKind::PulseOn, "G89"), drill(1, 1, 2)}, setting),
              HasSubstr("G0 X1 Y2\nG0 Z0.5\nG1 Z-0.5 F1200\nG0 Z-0.246\nG1 Z-1.5\n"
                        "G0 Z-1.246\nG1 Z-1.8\nG0 Z5\nM5\n"));
  setting.usual.peck = mm(0.002);
  EXPECT_THAT(
      write_out({take(1), function(FunctionKind::PeckOn, "M62"), drill(1, 1, 2)}, setting).failure,
      HasSubstr("1000 strokes"));
}

TEST(GcodeFlavour, PecksComeOutWithTheToolsRetractRate) {
  GcodeSetting setting = of(GcodeFlavour::Grbl);
  setting.approach_z = mm(0.5);
  setting.usual.peck = mm(2);
  setting.usual.retract = mm_per_s(100);
  EXPECT_THAT(text_of({take(1), function(FunctionKind::PeckOn, "M62"), drill(1, 1, 2)}, setting),
              HasSubstr("G0 Z0.5\nG1 Z-1.5 F1200\nG1 Z0.5 F6000\nG0 Z-1.246\n"
                        "G1 Z-1.8 F1200\nG1 Z5 F6000\nM5\n"));
}

TEST(GcodeFlavour, GrblStopsAtAnOptionalStopAndTakesNoCommandOutOfWords) {
  const std::string text =
      text_of({take(1), Message{"go on? ~yes! (really)"}, Stop{StopKind::Optional, {}, {}}},
              of(GcodeFlavour::Grbl));
  EXPECT_THAT(text, HasSubstr("(MSG, go on. .yes. [really])\nM0\nM0\n"));
  EXPECT_THAT(text, Not(HasSubstr("M1\n")));
  EXPECT_THAT(text_of({Message{"a;b*c"}}, of(GcodeFlavour::Marlin)), HasSubstr("M117 a.b.c\n"));
}

TEST(GcodeFlavour, GrblReadsLinesOf79Characters) {
  const std::string words(200, 'w');
  const std::string text = text_of(
      {take(1),
       Message{words},
       rapid_move(-1234.567891, -1234.567891),
       Plunge{},
       rout_arc(RoutKind::Clockwise, 1, -1214.567891, -1214.567891, -1214.567891, -1234.567891)},
      of(GcodeFlavour::Grbl));
  EXPECT_LE(longest_line(text), 79U) << text;
  EXPECT_THAT(text, HasSubstr("\nG2 X-1214.567891 Y-1214.567891 I20 J0"));
}

}  // namespace
}  // namespace panelcal
