// SPDX-License-Identifier: Apache-2.0
// Actions that the machine does by itself, where the program says so: passed on in order, never
// dropped.
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using test::expect_refused;
using test::format_5000;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::says;
using test::steps_of;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

/// Steps of a program without any problem.
std::vector<std::string> clean_steps(std::string_view body, const WalkOptions& options = {}) {
  const ProgramRun run = run_5000(body, options);
  EXPECT_THAT(run.diagnostics, Not(Contains(testing::HasSubstr("error["))));
  for (const std::string& text : run.diagnostics) {
    EXPECT_THAT(text, testing::HasSubstr("[tool-unused]")) << "in " << body;
  }
  return steps_of(run);
}

WalkOptions obeying_areas(bool obeys) {
  WalkOptions options;
  options.sieb_meyer.obeys_areas = obeys;
  return options;
}

// --- machine functions ---------------------------------------------------------------------------

/// M21 and Mxx: "activated when this coordinate is executed".
TEST(SiebMeyerEvents, MachineFunctionsAreDoneBeforeTheirCoordinate) {
  for (const std::string code :
       {"M21", "M22", "M23", "M24", "M25", "M26", "M27", "M34", "M35", "M36", "M37", "M38",
        "M39", "M40", "M41", "M42", "M43", "M44", "M45", "M52", "M53", "M54", "M55"}) {
    EXPECT_THAT(clean_steps("X1.Y1.T1\nX2.Y2." + code + "\n" + code + "\n"),
                ElementsAre("tool 1",
                            "drill 1 (1, 1)",
                            "function machine_function " + code,
                            "drill 1 (2, 2)",
                            "function machine_function " + code))
        << code;
  }
}

/// Of these only M21 exists in the formats below 5000.
TEST(SiebMeyerEvents, MachineFunctionsBelongToFormat5000) {
  const ProgramRun run = run_program("%%3000\nX1.Y1.T1M21\n$\nT1D100\n$\n");
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run), Contains("function machine_function M21"));
  expect_refused(run_program("%%3000\nX1.Y1.T1M34\n$\nT1D100\n$\n"), 2, {"M34"});
}

/// "The machine is stopped before this coordinate is executed"; "only allowed in drilling blocks
/// and in a T0 block of a routing track".
TEST(SiebMeyerEvents, OptionalStopComesBeforeTheCoordinate) {
  EXPECT_THAT(clean_steps("X1.Y1.T1\nX2.Y2.M20\nM20\n"),
              ElementsAre("tool 1", "drill 1 (1, 1)", "optional", "drill 1 (2, 2)", "optional"));
  EXPECT_THAT(
      clean_steps("X10.Y50.T0T5M20\nX50.Y50.G1F1.\nX50.Y50.T0\n"),
      ElementsAre(
          "tool 5", "optional", "position (10, 50)", "plunge", "rout 5 line (50, 50)", "retract"));
}

/// M28, M29: "The axes are positioned after the coordinate has been executed"; without one "the
/// XY-axes move directly".
TEST(SiebMeyerEvents, MachineZeroAndParkPositionComeBehindTheCoordinate) {
  EXPECT_THAT(clean_steps("X1.Y1.T1\nX5.Y5.M28\nX6.Y6.M29\nM28\nM29\n"),
              ElementsAre("tool 1",
                          "drill 1 (1, 1)",
                          "drill 1 (5, 5)",
                          "function machine_zero M28",
                          "drill 1 (6, 6)",
                          "function park_position M29",
                          "function machine_zero M28",
                          "function park_position M29"));
}

/// "Programming the command with XY-coordinates is only allowed in drilling and routing blocks":
/// the line's piece is routed, and the cutter comes up before the table leaves.
TEST(SiebMeyerEvents, MachineZeroAndParkPositionComeBehindTheLastPieceOfAContour) {
  for (const std::string code : {"M28", "M29"}) {
    const std::string leaves =
        code == "M28" ? "function machine_zero M28" : "function park_position M29";
    EXPECT_THAT(clean_steps("X10.Y50.T0T5\nX50.Y50.G1F1.\nX50.Y80." + code + "\nT0\nX1.Y1.\n"),
                ElementsAre("tool 5",
                            "position (10, 50)",
                            "plunge",
                            "rout 5 line (50, 50)",
                            "rout 5 line (50, 80)",
                            "retract",
                            leaves,
                            "drill 5 (1, 1)"));
  }
  EXPECT_THAT(clean_steps("X50.Y50.T0T5\nX50.Y50.G47R10.F1.M28\nX50.Y50.T0\n"),
              testing::Contains("function machine_zero M28"));
  // Where the contour would go on, and where the table leaves in its middle.
  const std::string contour = "X10.Y50.T0T5\nX50.Y50.G1F1.M28\n";
  for (const std::string line : {"X50.Y80.\n", "X50.Y80.G1\n", "X50.Y80.T6\n"}) {
    expect_refused(run_program(format_5000(contour + line + "X50.Y80.T0\n")), 4, {"T0"});
  }
  expect_refused(
      run_program(format_5000("X10.Y50.T0T5\nX50.Y50.G1F1.\nM28\nX50.Y50.T0\n")), 4, {"T0"});
}

/// "The function already applies for the coordinates in the block."
TEST(SiebMeyerEvents, BreakageMonitoringAppliesToItsOwnCoordinate) {
  EXPECT_THAT(clean_steps("X1.Y1.T1M94\nX2.Y2.\nX3.Y3.M95\n"),
              ElementsAre("tool 1",
                          "function breakage_check_off M94",
                          "drill 1 (1, 1)",
                          "drill 1 (2, 2)",
                          "function breakage_check_on M95",
                          "drill 1 (3, 3)"));
}

// --- texts ---------------------------------------------------------------------------------------

/// "M47,text" and "M47text" are the same; the signs at its beginning are the control's.
TEST(SiebMeyerEvents, MessagesArePassedOnAsTheyStand) {
  EXPECT_THAT(clean_steps("X1.Y1.T1\nM47,TURN BOARD\nM47TURN BOARD\nM47,&P!TURN BOARD\nX2.Y2.\n"),
              ElementsAre("tool 1",
                          "drill 1 (1, 1)",
                          "message TURN BOARD",
                          "message TURN BOARD",
                          "message &P!TURN BOARD",
                          "drill 1 (2, 2)"));
}

TEST(SiebMeyerEvents, TextsForTheCameraAndOtherDevicesArePassedOn) {
  EXPECT_THAT(clean_steps("X1.Y1.T1\nM75,FIND A\nM76,LOT 7\nX2.Y2.\n"),
              ElementsAre("tool 1",
                          "drill 1 (1, 1)",
                          "setting M75,FIND A",
                          "function text_for_device LOT 7",
                          "drill 1 (2, 2)"));
}

// --- peck and pulse drilling ---------------------------------------------------------------------

/// The manual's line for peck drilling; 1.4, 2.8 and 4.0 mm reach Z1.
TEST(SiebMeyerEvents, PeckDrillingHoldsFromItsCoordinateOn) {
  EXPECT_THAT(clean_steps("Z1.\nX2.Y7.T2G81I5.P80J1.4W1000\nX3.Y7.\nX4.Y7.G80\nX5.Y7.G81\n"),
              ElementsAre("tool 2",
                          "function peck_on G81I5.P80J1.4W1000",
                          "drill 2 (2, 7) z 1",
                          "drill 2 (3, 7) z 1",
                          "function peck_off G80",
                          "drill 2 (4, 7) z 1",
                          "function peck_on G81",
                          "drill 2 (5, 7) z 1"));
}

/// The manual's table of strokes: "Target plane not reached" after the 11th, at 2.104 mm.
TEST(SiebMeyerEvents, PeckDrillingThatEndsTooHighIsReported) {
  const ProgramRun run = run_5000("X1.Y1.T1Z2.G81I4.5P20J1.2W500\n");
  EXPECT_THAT(run.texts, Contains(AllOf(says(2, "11 "), says(2, "0.104 mm"))));
}

/// The numbers may also follow while G81 is in force: "X10.Y20. I4.5 P20 J1.2 W500 Z2."
TEST(SiebMeyerEvents, PeckNumbersMayFollow) {
  const ProgramRun run = run_5000("X1.Y1.T1Z2.G81I5.P80J1.4W1000\nX10.Y20.I4.5P20J1.2W500Z2.\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "function peck_on G81I5.P80J1.4W1000",
                          "drill 1 (1, 1) z 2",
                          "function peck_on G81I4.5P20J1.2W500",
                          "drill 1 (10, 20) z 2"));
}

/// The manual's line for pulse drilling.
TEST(SiebMeyerEvents, PulseDrillingHoldsFromItsCoordinateOn) {
  EXPECT_THAT(clean_steps("Z1.8\nX123.456Y789.123T2G89I5.J1.4E30R0.2\nX1.Y1.G88\nX2.Y2.G89\n"),
              ElementsAre("tool 2",
                          "function pulse_on G89I5.J1.4E30R0.2",
                          "drill 2 (123.456, 789.123) z 1.8",
                          "function pulse_off G88",
                          "drill 2 (1, 1) z 1.8",
                          "function pulse_on G89",
                          "drill 2 (2, 2) z 1.8"));
}

/// "Pulse drilling and peck drilling cannot be used at the same time": the one ends first.
TEST(SiebMeyerEvents, PulseDrillingEndsBeforePeckDrillingBegins) {
  EXPECT_THAT(clean_steps("X1.Y1.T1Z1.8G89I5.J1.4E30R0.2\nX2.Y1.G88G81I5.P80J1.4W1000\n"
                          "X3.Y1.G80G89\n"),
              ElementsAre("tool 1",
                          "function pulse_on G89I5.J1.4E30R0.2",
                          "drill 1 (1, 1) z 1.8",
                          "function pulse_off G88",
                          "function peck_on G81I5.P80J1.4W1000",
                          "drill 1 (2, 1) z 1.8",
                          "function peck_off G80",
                          "function pulse_on G89",
                          "drill 1 (3, 1) z 1.8"));
}

/// A program that does not say G88 or G80 itself relies on a control that has both on at once.
TEST(SiebMeyerEvents, WhatTheOtherDrillingReplacesIsSaidToEnd) {
  EXPECT_THAT(steps_of(run_5000("X1.Y1.T1Z1.8G89I5.J1.4\nX2.Y1.G81I5.P80J1.4W1000\n"
                                "X3.Y1.G89\nX4.Y1.G88\n")),
              ElementsAre("tool 1",
                          "function pulse_on G89I5.J1.4",
                          "drill 1 (1, 1) z 1.8",
                          "function pulse_off G88",
                          "function peck_on G81I5.P80J1.4W1000",
                          "drill 1 (2, 1) z 1.8",
                          "function peck_off G80",
                          "function pulse_on G89",
                          "drill 1 (3, 1) z 1.8",
                          "function pulse_off G88",
                          "drill 1 (4, 1) z 1.8"));
}

TEST(SiebMeyerEvents, DwellAndMinimumStrokeOfPulseDrillingMayFollow) {
  EXPECT_THAT(clean_steps("X1.Y1.T1Z1.8G89I5.J1.4\nX2.Y1.E50R.3\n"),
              ElementsAre("tool 1",
                          "function pulse_on G89I5.J1.4",
                          "drill 1 (1, 1) z 1.8",
                          "function pulse_on G89E50R0.3",
                          "drill 1 (2, 1) z 1.8"));
}

TEST(SiebMeyerEvents, RefusesPeckNumbersThatMeanNothing) {
  expect_refused(run_program(format_5000("X1.Y1.T1G81P101\n")), 2, {"P of 0 to 100"});
  expect_refused(run_program(format_5000("X1.Y1.T1G81W1001\n")), 2, {"W of 0 to 1000"});
  expect_refused(run_program(format_5000("X1.Y1.T1G89P20\n")), 2, {"G81"});
  expect_refused(run_program(format_5000("X1.Y1.T1G81E20\n")), 2, {"G89"});
}

// --- areas ---------------------------------------------------------------------------------------

/// The manual's check areas: passed on, and nothing is drilled there.
TEST(SiebMeyerEvents, CheckAreasArePassedOn) {
  EXPECT_THAT(clean_steps("X10.Y20.M56\nX450.Y20.M57\nX1.Y1.T1\n", obeying_areas(true)),
              ElementsAre("function check_area X10.000Y20.000M56",
                          "function check_area X450.000Y20.000M57",
                          "tool 1",
                          "drill 1 (1, 1)"));
}

/// In brackets that nothing repeats, and in a subprogram with its zero at program zero, they stand
/// where they are programmed; in copies elsewhere they could be the copy's own or not.
TEST(SiebMeyerEvents, CheckAreasMayStandWhereNothingMovesThem) {
  test::SubprogramFolder folder;
  folder.with("SETUP.SS5", "@SETUP\nX10.Y20.M56\nX450.Y20.M57\n");
  const auto has_areas = testing::IsSupersetOf(
      {"function check_area X10.000Y20.000M56", "function check_area X450.000Y20.000M57"});
  const std::string areas = "X10.Y20.M56\nX450.Y20.M57\n";
  const WalkOptions options = obeying_areas(true);
  EXPECT_THAT(steps_of(run_5000("M99,SETUP\nX1.Y1.T1\n", options, folder.reading())), has_areas);
  EXPECT_THAT(steps_of(run_5000("M31\n" + areas + "X1.Y1.T1M30\n", options)), has_areas);
  EXPECT_THAT(steps_of(run_5000("M31\n" + areas + "X1.Y1.T1\nXYM50M30\n", options)),
              Contains("function check_area X10.000Y20.000M56 [0]"));
  const auto refused = [&](const std::string& body, const std::string& place) {
    const ProgramRun run = run_program(format_5000(body), options, folder.reading());
    EXPECT_THAT(run.diagnostics, Contains(testing::HasSubstr(place + ": error[not-supported]")));
  };
  const auto texts_of = [&](const std::string& body) {
    return run_program(format_5000(body), options).texts;
  };
  EXPECT_THAT(texts_of("M31\n" + areas + "X1.Y1.T1\nXYM50\nX5.Y0M50M30\n"),
              Contains(testing::AllOf(testing::HasSubstr("under the offset of a section or call"),
                                      testing::HasSubstr("X#Y#M57 ahead of it"))));
  EXPECT_THAT(texts_of("X0Y0G33\nG31\n" + areas + "X1.Y1.T1\n"),
              Contains(testing::HasSubstr("under a correction")));
  EXPECT_THAT(texts_of("M49,SAX3.Y100.\nM93\n" + areas + "X1.Y1.T1\n"),
              Contains(testing::HasSubstr("under a scale or rotation")));
  refused("X1.Y1.M99,SETUP\nX1.Y1.T1\n", "SETUP.SS5:2:1");
  refused("M31\n" + areas + "X1.Y1.T1\nXYM50\nXYM50\nXY9.M50M30\n", "p.exc:3:1");
}

/// "If a drill hole is within a Forbidden Area, the drill hole is omitted"; "the diameter serves as
/// edge length, since the Forbidden Areas are considered as squares".
TEST(SiebMeyerEvents, HolesInForbiddenAreasAreLeftOutAndReported) {
  const ProgramRun run = run_5000("X10.Y10.M58D4.\nX11.9Y11.9T1\nX12.1Y10.\nX10.Y7.9\nX8.1Y8.1\n",
                                  obeying_areas(true));
  EXPECT_THAT(steps_of(run),
              ElementsAre("function forbidden_area",
                          "tool 1",
                          "function hole_omitted",
                          "drill 1 (12.1, 10)",
                          "drill 1 (10, 7.9)",
                          "function hole_omitted"));
  EXPECT_THAT(run.texts, Contains(says(3, "(11.9000, 11.9000) mm")));
  EXPECT_THAT(run.texts, Contains(says(6, "(8.1000, 8.1000) mm")));
}

/// "The CNC command PRGM,C must be active."
TEST(SiebMeyerEvents, AreasAreObeyedIfPrgmOrTheConfigurationSaysSo) {
  const std::string body = "X10.Y10.M58D4.\nX10.Y10.T1\n";
  EXPECT_THAT(run_5000("M49,PRGM,C\n" + body).holes(), IsEmpty());
  EXPECT_EQ(run_5000("M49,PRGM,-C\n" + body).holes().size(), 1U);
  EXPECT_EQ(run_5000(body, obeying_areas(false)).holes().size(), 1U);
  EXPECT_THAT(run_5000("M49,PRGM,C\n" + body, obeying_areas(false)).holes(), IsEmpty());
  // If no setting states it they are obeyed, with a warning.
  const ProgramRun silent = run_5000(body);
  EXPECT_THAT(silent.holes(), IsEmpty());
  EXPECT_THAT(silent.diagnostics, Contains(says(2, "[areas-assumed]")));
}

/// "A maximum of 99 Forbidden Areas can be defined"; D has to have a length.
TEST(SiebMeyerEvents, RefusesAreasThatTheControlDoesNotTake) {
  std::string body = "M49,PRGM,C\n";
  for (int i = 0; i < 100; ++i) body += "X" + std::to_string(i) + ".Y1.M58D.5\n";
  expect_refused(run_program(format_5000(body + "X1.Y50.T1\n")), 2 + 100, {"99"});
  expect_refused(run_program(format_5000("M49,PRGM,C\nX1.Y1.M58\nX1.Y50.T1\n")), 3, {"M58D"});
  expect_refused(run_program(format_5000("M49,PRGM,C\nM56\nX1.Y50.T1\n")), 3, {"X#Y#"});
}

// --- finish routing ------------------------------------------------------------------------------

TEST(SiebMeyerEvents, FinishRoutingComesBeforeItsTrack) {
  EXPECT_THAT(clean_steps("X10.Y50.T0T5\nX50.Y50.G1F1.\nX50.Y80.G11\nX50.Y80.T0\n"),
              ElementsAre("tool 5",
                          "position (10, 50)",
                          "plunge",
                          "rout 5 line (50, 50)",
                          "function finish_routing G11",
                          "rout 5 line (50, 80)",
                          "retract"));
}

/// The manual's table: G47 and G48 have it, G45, G46, G49 and G50 ignore it.
TEST(SiebMeyerEvents, FinishRoutingIsIgnoredInsideHoles) {
  const auto finishes = [](const std::string& figure) {
    const auto steps = clean_steps("X50.Y50.T0T5\nX50.Y50." + figure + "F1.G11\nX50.Y50.T0\n");
    return std::ranges::count(steps, "function finish_routing G11");
  };
  EXPECT_EQ(finishes("G47R10."), 1);
  EXPECT_EQ(finishes("G48R10."), 1);
  for (const std::string figure : {"G45R10.", "G46R10.", "G49R10.", "G50R10."}) {
    EXPECT_EQ(finishes(figure), 0) << figure;
  }
}

}  // namespace
}  // namespace panelcal
