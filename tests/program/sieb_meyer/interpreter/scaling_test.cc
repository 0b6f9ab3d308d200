// SPDX-License-Identifier: Apache-2.0
// Commands that move all coordinates of a program: scale, rotation, program zero and axis version.
// The manual shows SA, SAZ, FA and their ends; numbers here follow from what its text says of them.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::expect_places;
using test::expect_refused;
using test::format_5000;
using test::FunctionSource;
using test::hole_places;
using test::IsNearMatrix;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::steps_of;
using test::SubprogramFolder;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// SAX3.Y100. is 3 um and 100 um per metre about SAZX200.Y400.
Vector2d scaled(const Vector2d& p_mm) {
  const Vector2d about_mm(200, 400);
  return about_mm + (p_mm - about_mm).cwiseProduct(Vector2d(1.000003, 1.0001));
}

/// The example of M92 and M93: "The holes for board finishing shall not be scaled."
TEST(SiebMeyerScaling, TheManualsSectionIsScaledAndTheFinishIsNot) {
  SubprogramFolder folder;
  folder.with("SHOP.SS5",
              "@RESET\nM49,NOFA\nM49,NORA\nM49,NOSA\n"
              "@FINAL\nXYT9\nXY500.\nX300.Y500.\nX300.Y\n");
  const ProgramRun run = run_5000(
      "M99,RESET\nM49,SAX3.Y100.\nM49,SAZX200.Y400.\nX12.345Y34.567T1M31M93\n"
      "X45.6Y43.21M50M30M92\nM99,FINAL\nM99,RESET\n",
      {},
      folder.reading());
  expect_places(hole_places(run),
                {scaled({12.345 + 45.6, 34.567 + 43.21}), {0, 0}, {0, 500}, {300, 500}, {300, 0}});
}

/// "Scaled execution already applies for these coordinates."
TEST(SiebMeyerScaling, M93AndM92HoldForTheirOwnLine) {
  const ProgramRun run = run_5000(
      "M49,SAX3.Y100.\nM49,SAZX200.Y400.\nX10.Y10.T1M92\nX20.Y10.M93\nX30.Y10.\nX40.Y10.M92\n");
  expect_places(hole_places(run), {{10, 10}, scaled({20, 10}), scaled({30, 10}), {40, 10}});
}

/// Offsets are scaled with the rest: the centre is a place on the table.
TEST(SiebMeyerScaling, EveryCopyIsScaledAboutTheSameCentre) {
  const ProgramRun run = run_5000(
      "M49,SAX3.Y100.\nM49,SAZX200.Y400.\nX1.Y2.T1M31M93\nXYM50\nX100.YM50\nXY100.M80M30\n");
  expect_places(hole_places(run), {scaled({1, 2}), scaled({101, 2}), scaled({1, 98})});
}

TEST(SiebMeyerScaling, NosaEndsTheScaleAndForgetsTheCentre) {
  const ProgramRun run = run_5000(
      "M49,SAX3.Y100.\nM49,SAZX200.Y400.\nM49,NOSA\nX10.Y10.T1M93\nM49,SAX3.Y100.\nX1000.Y10.\n");
  expect_places(hole_places(run), {{10, 10}, {1000.003, 10.001}});
}

std::vector<std::string> of_scaling(const ProgramRun& run) {
  std::vector<std::string> briefs;
  for (const std::string& text : run.diagnostics) {
    if (text.find("[scaling-") != std::string::npos) {
      briefs.push_back(text.substr(0, text.find("]") + 1));
    }
  }
  return briefs;
}

std::string at_line(int line) {
  return "p.exc:" + std::to_string(line) + ":1:";
}

/// "The scaling commands can be used for limiting the scaling function to certain program
/// sections": SA that none of them limits scales. The warning comes once, at the first coordinate.
TEST(SiebMeyerScaling, SaAloneScalesWithAWarning) {
  const ProgramRun run =
      run_5000("M49,SAX3.Y100.\nM49,SAZX200.Y400.\nX1.Y1.T1\nX2.Y2.\nX3.Y3.M92\nX4.Y4.M93\n");
  expect_places(hole_places(run), {scaled({1, 1}), scaled({2, 2}), {3, 3}, scaled({4, 4})});
  EXPECT_THAT(of_scaling(run), ElementsAre("p.exc:4:1: warning[scaling-assumed]"));
}

/// Whatever has a place: targets, probes, contours and areas, also where no hole comes first.
TEST(SiebMeyerScaling, AllPlacesOfSaAloneAreScaledWithAWarning) {
  const std::string scale = "M49,SAX1000.Y\n";
  const std::string assumed = ":1: warning[scaling-assumed]";
  const auto steps_under_sa = [&](const std::string& body, const WalkOptions& options = {}) {
    const ProgramRun run = run_5000(scale + body, options);
    EXPECT_THAT(of_scaling(run), ElementsAre("p.exc:3" + assumed)) << body;
    return steps_of(run);
  };
  EXPECT_THAT(steps_under_sa("X100.Y1.T0T1\nX200.Y1.G1F1.\nX200.Y1.T0\n"),
              Contains("rout 1 line (200.2, 1)"));
  EXPECT_THAT(steps_under_sa("X100.Y9.T0T1\nX100.Y9.G45R5.\nX100.Y9.T0\n"),
              Contains(HasSubstr("(95.5955, 9)")));
  EXPECT_THAT(steps_under_sa("X100.Y5.T1G84R3.\n"), Contains("drill 1 (102.6025, 5)"));

  WalkOptions keeping;
  keeping.slots = Cycles::Kept;
  const ProgramRun slot = run_5000(scale + "X100.Y1.T1G85\nX200.Y1.\n", keeping);
  EXPECT_THAT(of_scaling(slot), ElementsAre("p.exc:4" + assumed));
  EXPECT_THAT(steps_of(slot), Contains("slot 1 (100.1, 1) (200.2, 1)"));

  FunctionSource source([](const MeasurementRequest& request) { return request.nominal.in_mm(); });
  const ProgramRun targets = run_5000(scale + "X100.Y1.G32\nG31\n", {}, source);
  EXPECT_THAT(of_scaling(targets), ElementsAre("p.exc:3" + assumed));
  ASSERT_EQ(source.requests().size(), 1U);
  EXPECT_THAT(source.requests()[0].nominal.in_mm(), IsNearMatrix(Vector2d(100.1, 1), 1e-9));

  const ProgramRun probe = run_5000(scale + "X100.Y1.G73\n");
  EXPECT_THAT(of_scaling(probe), ElementsAre("p.exc:3" + assumed));
  ASSERT_EQ(probe.survey.probes.size(), 1U);
  EXPECT_THAT(probe.survey.probes[0].request.nominal.in_mm(),
              IsNearMatrix(Vector2d(100.1, 1), 1e-9));

  // The area's centre is scaled as well: 1000 +- 2 becomes 1001 +- 2.
  WalkOptions obeying;
  obeying.sieb_meyer.obeys_areas = true;
  const ProgramRun area =
      run_5000("M49,FORB,A\n" + scale + "X1000.Y1.M58D4.\nM92\nX998.5Y1.T1\nX1002.5Y1.\n", obeying);
  EXPECT_THAT(of_scaling(area), ElementsAre("p.exc:4" + assumed));
  expect_places(hole_places(area), {{998.5, 1}});
}

/// Nothing is assumed where M93, M92 or NOSA decide before the first coordinate, nor of a scale
/// of 1.
TEST(SiebMeyerScaling, NothingIsAssumedWhereTheProgramDecides) {
  for (const char* body : {"M49,SAX3.Y100.\nX1.Y1.T1M93\nX2.Y2.\n",
                           "M49,SAX3.Y100.\nX1.Y1.T1M92\nX2.Y2.M93\n",
                           "M93\nM49,SAX3.Y100.\nX1.Y1.T1\n",
                           "M49,SAX3.Y100.\nM49,NOSA\nX1.Y1.T1\n",
                           "M49,SAX0Y0\nX1.Y1.T1\n"}) {
    EXPECT_THAT(of_scaling(run_5000(body)), IsEmpty()) << body;
  }
}

/// M93 behind such coordinates says that they were not meant to be scaled: no reading is safe.
TEST(SiebMeyerScaling, RefusesM93BehindCoordinatesThatSaAloneScales) {
  const ProgramRun run = run_program(format_5000("M49,SAX3.Y100.\nX1.Y1.T1\nX2.Y2.M93\nX3.Y3.\n"));
  EXPECT_THAT(
      of_scaling(run),
      ElementsAre("p.exc:3:1: warning[scaling-assumed]", "p.exc:4:1: error[scaling-undecided]"));
  // Behind NOSA the next SA begins anew.
  const ProgramRun anew =
      run_5000("M49,SAX1000.Y\nX100.YT1\nM49,NOSA\nX100.Y\nM49,SAX2000.Y\nX100.YM93\n");
  expect_places(hole_places(anew), {{100.1, 0}, {100, 0}, {100.2, 0}});
}

/// M92 holds until M93. Whether a new SA begins anew no sentence of the manual states.
TEST(SiebMeyerScaling, SaBehindM92HoldsFromM93OnWithAWarning) {
  for (const char* body :
       {"M49,SAX2000.Y\nX100.YT1M93\nX100.YM92\nM49,NOSA\n", "M92\nX100.YT1\n"}) {
    const ProgramRun run =
        run_5000(std::string(body) + "(SA)\nM49,SAX1000.Y\nX100.Y\nX200.Y\nX100.YM93\n");
    const Places all = hole_places(run);
    ASSERT_GE(all.size(), 3U);
    expect_places({all.end() - 3, all.end()}, {{100, 0}, {200, 0}, {100.1, 0}});
    const int line = body[0] == 'M' && body[1] == '9' ? 6 : 8;
    EXPECT_THAT(of_scaling(run), ElementsAre(at_line(line) + " warning[scaling-assumed]"));
  }
  // M93 decides before a coordinate does, and the next scale may be set ahead of its section.
  EXPECT_THAT(of_scaling(run_5000("M92\nM49,SAX1000.Y\nX100.YT1M93\nX9.YM92\nX1.Y\n"
                                  "M49,SAX2000.Y\nX100.YM93\n")),
              IsEmpty());
}

/// A section that SA alone scales is scaled in every copy, and its end may end the scale.
TEST(SiebMeyerScaling, SaAloneScalesCopies) {
  const ProgramRun run = run_5000("M49,SAX1000.Y\nX10.YT1M31\nXYM50\nX100.YM50M30M92\nX10.Y5.\n");
  expect_places(hole_places(run), {{10.01, 0}, {110.11, 0}, {10, 5}});
}

/// The second copy would begin with what M92 or M93 has left in the first one.
TEST(SiebMeyerScaling, RefusesSectionsWhoseCopiesWouldBeScaledUnlike) {
  const std::string copies = "XYM50\nX100.YM50M30\n";
  const auto of_section = [&](const std::string& body, const std::string& end = "") {
    return of_scaling(run_program(format_5000("M49,SAX1000.Y\n" + body + copies + end)));
  };
  const std::string assumed = "warning[scaling-assumed]";
  const std::string undecided = "error[scaling-undecided]";
  EXPECT_THAT(of_section("X10.YT1M31\nX20.YM92\n"),
              ElementsAre(at_line(3) + " " + assumed, at_line(5) + " " + undecided));
  EXPECT_THAT(of_section("X9.YT1M93\nX10.YM31\nX20.YM92\n"),
              ElementsAre(at_line(6) + " " + undecided));
  EXPECT_THAT(of_section("X9.YT1M92\nX10.YM31\nX20.YM93\n"),
              ElementsAre(at_line(6) + " " + undecided));
  // In the end of a section that another one copies.
  EXPECT_THAT(of_section("M31\nX10.YT1M31\nXYM50\nX10.YM50M30M92\n"),
              ElementsAre(at_line(4) + " " + assumed, at_line(7) + " " + undecided));
  // By another section among the lines of its copies.
  EXPECT_THAT(of_section("X9.YT1M93\nX10.YM31\nX20.YM31M92\nXYM50\nX10.YM50M30\n"),
              ElementsAre(at_line(8) + " " + undecided));
  // Copies that are alike: the first coordinate decides, or the last one ends as it began.
  EXPECT_THAT(of_section("X10.YT1M31M93\nX20.YM92\n"), IsEmpty());
  EXPECT_THAT(of_section("X9.YT1M93\nX10.YM31\nX20.YM92\nX30.YM93\n"), IsEmpty());
  EXPECT_THAT(of_section("M31\nX10.YT1M31M93\nXYM50\nX10.YM50M30M92\n"), IsEmpty());
  // One copy is like itself.
  EXPECT_THAT(
      of_scaling(run_5000("M49,SAX1000.Y\nX9.YT1M93\nX10.YM31\nX20.YM92\nX100.YM50M30\nX1.Y\n")),
      IsEmpty());
}

TEST(SiebMeyerScaling, RefusesScalesThatNoBoardHas) {
  expect_refused(run_program(format_5000("M49,SAX100001.\nX1.Y1.T1M93\n")), 2, {"100000"});
  expect_refused(run_program(format_5000("M49,SA\nX1.Y1.T1M93\n")), 2, {"SAX#Y#"});
  expect_refused(run_program(format_5000("M49,SAZ5\nX1.Y1.T1M93\n")), 2, {"SAZX#Y#"});
}

TEST(SiebMeyerScaling, RaTurnsCounterclockwiseAboutProgramZero) {
  const ProgramRun run =
      run_5000("M49,RA90.\nX10.YT1\nM49,RA-30\nX10.Y\nM49,NORA\nX10.Y\nX1.YM31\nX5.YM50M30\n");
  const double cos_30 = 0.86602540378443865;
  expect_places(hole_places(run), {{0, 10}, {10 * cos_30, -5}, {10, 0}, {6, 0}});
}

/// Copies turn with their offsets.
TEST(SiebMeyerScaling, RaTurnsWholePatterns) {
  const ProgramRun run = run_5000("M49,RA90\nX1.Y2.T1M31\nXYM50\nX100.YM50M30\n");
  expect_places(hole_places(run), {{-2, 1}, {-2, 101}});
  expect_refused(run_program(format_5000("M49,RA361\nX1.Y1.T1\n")), 2, {"RA# in degrees"});
}

/// "Example for program zero setting via CNC command": M49,FAX123.432Y256.753
TEST(SiebMeyerScaling, FaPutsProgramZeroToAPlaceOnTheMachine) {
  WalkOptions options;
  options.work_zero = position_mm<frame::Machine>(100, 200);
  const ProgramRun run =
      run_5000("X1.Y1.T1\nM49,FAX123.432Y256.753\nX1.Y1.\nM49,NOFA\nX1.Y1.\n", options);
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (101, 201)",
                          "work zero (123.432, 256.753)",
                          "drill 1 (124.432, 257.753)",
                          "work zero (100, 200)",
                          "drill 1 (101, 201)"));
  expect_refused(run_program(format_5000("M49,FAX5.\nX1.Y1.T1\n")), 2, {"FAX#Y#"});
}

/// The measured places are relative to the old program zero.
TEST(SiebMeyerScaling, RefusesFaUnderACorrection) {
  expect_refused(
      run_program(format_5000("X10.Y10.G32\nG31\nX1.Y1.T1\nM49,FAX5.Y5.\nX2.Y2.\n")), 5, {"G30"});
}

/// Version 2: x up and y to the right as one stands before the table (docs/decisions).
TEST(SiebMeyerScaling, FvSaysWhereTheAxesPoint) {
  expect_places(hole_places(run_5000("M49,FV1\nX10.Y3.T1\n")), {{10, 3}});
  expect_places(hole_places(run_5000("M49,FV2\nX10.Y3.T1\n")), {{3, 10}});
  expect_refused(run_program(format_5000("M49,FV9\nX1.Y1.T1\n")), 2, {"FV1 to FV8"});
  expect_refused(run_program(format_5000("X1.Y1.T1\nM49,FV2\nX2.Y2.\n")), 3, {"first coordinate"});
}

/// Offsets without brackets move the whole program; its axes are no part of what they repeat.
TEST(SiebMeyerScaling, FvMayBeginAProgramThatOffsetsWithoutBracketsRepeat) {
  const std::string moved = "X10.Y3.T1\nXYM50\nX100.YM50\n";
  expect_places(hole_places(run_5000("(AXES)\nM49,FV2\n" + moved)), {{3, 10}, {3, 110}});
  EXPECT_THAT(
      steps_of(run_5000("M49,FV2\n" + moved)),
      ElementsAre("setting M49,FV2", "tool 1 [0]", "drill 1 (3, 10) [0]", "drill 1 (3, 110) [1]"));
  // Behind what is repeated, another copy would begin in other axes.
  expect_refused(run_program(format_5000("M47,A\nM49,FV2\n" + moved)), 3, {"brackets"});
}

}  // namespace
}  // namespace panelcal
