// SPDX-License-Identifier: Apache-2.0
// VER,1 to VER,8: which way a program's +x and +y point. Inside panelcal x points right, y up.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;
using test::ProgramRun;
using test::run_program;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kRounding_mm = 1e-9;

const Vector2d kRight(1, 0);
const Vector2d kLeft(-1, 0);
const Vector2d kUp(0, 1);
const Vector2d kDown(0, -1);

struct Version {
  int number;
  Vector2d plus_x, plus_y;  ///< directions of the program's axes
  bool mirrors;

  Vector2d turned(double x, double y) const { return x * plus_x + y * plus_y; }
};

const std::vector<Version>& versions() {
  static const std::vector<Version> all = {{1, kRight, kUp, false},
                                           {2, kUp, kRight, true},
                                           {3, kUp, kLeft, false},
                                           {4, kLeft, kUp, true},
                                           {5, kDown, kLeft, true},
                                           {6, kLeft, kDown, false},
                                           {7, kRight, kDown, true},
                                           {8, kDown, kRight, false}};
  return all;
}

/// `body` from line 6 on.
std::string program(const Version& version, const std::string& body) {
  return "M48\nVER," + std::to_string(version.number) + "\nMETRIC,LZ\nT1C1.\n%\n" + body + "M30\n";
}

ProgramRun run_clean(std::string text, const ReadOptions& reading = {}) {
  ProgramRun run = run_program(std::move(text), {}, reading);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

/// As the recorder writes places: `(1, 2)`.
std::string text_of(const Vector2d& p_mm) {
  return "(" + std::to_string(static_cast<int>(p_mm.x())) + ", " +
         std::to_string(static_cast<int>(p_mm.y())) + ")";
}

TEST(AxisVersion, TurnsHoles) {
  for (const Version& version : versions()) {
    const ProgramRun run = run_clean(program(version, "T1\nX10.Y20.\nX30.\nR1Y5.\n"));
    ASSERT_EQ(run.holes().size(), 3U);
    EXPECT_EQ(run.holes()[0].nominal_mm(), version.turned(10, 20)) << version.number;
    EXPECT_EQ(run.holes()[1].nominal_mm(), version.turned(30, 20)) << version.number;
    EXPECT_EQ(run.holes()[2].nominal_mm(), version.turned(30, 25)) << version.number;
  }
}

TEST(AxisVersion, StepAndRepeatAndItsMirrorsAreInTheProgramsAxes) {
  for (const Version& version : versions()) {
    const ProgramRun run =
        run_clean(program(version, "T1\nM25\nX10.Y20.\nM01\nM02X100.M80\nM02Y50.M70\nM08\n"));
    ASSERT_EQ(run.holes().size(), 3U);
    EXPECT_THAT(run.holes()[1].nominal_mm(), IsNearMatrix(version.turned(90, 20), kRounding_mm))
        << version.number;
    EXPECT_THAT(run.holes()[2].nominal_mm(), IsNearMatrix(version.turned(120, 60), kRounding_mm))
        << version.number;
  }
}

TEST(AxisVersion, TurnsArcsOverWhereItMirrors) {
  for (const Version& version : versions()) {
    const ProgramRun run =
        run_clean(program(version, "T1\nG00X10.Y0.\nM15\nG03X20.Y10.A10.\nG02X40.Y30.A20.\nM17\n"));
    const std::vector<Rout>& arcs = run.executed.routs();
    ASSERT_EQ(arcs.size(), 2U);
    const RoutKind same = version.mirrors ? RoutKind::Clockwise : RoutKind::Counterclockwise;
    const RoutKind other = version.mirrors ? RoutKind::Counterclockwise : RoutKind::Clockwise;
    EXPECT_EQ(arcs[0].kind, same) << version.number;
    EXPECT_EQ(arcs[1].kind, other) << version.number;
    EXPECT_THAT(arcs[0].nominal.in_mm(), IsNearMatrix(version.turned(20, 10), kRounding_mm));
    EXPECT_THAT(arcs[0].corrected_center.in_mm(),
                IsNearMatrix(version.turned(10, 10), kRounding_mm));
    EXPECT_THAT(arcs[1].corrected_center.in_mm(),
                IsNearMatrix(version.turned(40, 10), kRounding_mm));
  }
}

TEST(AxisVersion, TurnsCompensationOverWhereItMirrors) {
  for (const Version& version : versions()) {
    const ProgramRun run =
        run_clean(program(version, "T1\nG00X10.Y0.\nG41\nM15\nG01X20.Y0.\nM17\n"));
    EXPECT_THAT(run.executed.lines(),
                Contains(HasSubstr(version.mirrors ? " compensation right" : " compensation left")))
        << version.number;
  }
}

TEST(AxisVersion, TurnsZeroSetsAndStops) {
  for (const Version& version : versions()) {
    EXPECT_THAT(
        run_clean(program(version, "T1\nG93X10.Y20.\nX1.Y2.\nM09X3.Y4.\n")).executed.lines(),
        AllOf(Contains("7 work zero " + text_of(version.turned(10, 20))),
              Contains("8 drill 1 " + text_of(version.turned(11, 22))),
              Contains("9 inspection " + text_of(version.turned(3, 4)))))
        << version.number;
  }
}

TEST(AxisVersion, TurnsTargets) {
  for (const Version& version : versions()) {
    test::FunctionSource panel = test::shifted_by(0.1, 0.2);
    const ProgramRun run =
        run_program(program(version, "G34,1\nT1\nG35X10.Y20.\nX30.Y40.\n"), {}, panel);
    ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
    ASSERT_EQ(panel.requests().size(), 1U);
    EXPECT_EQ(panel.requests()[0].nominal.in_mm(), version.turned(10, 20)) << version.number;
    // The camera sees in internal axes.
    ASSERT_EQ(run.holes().size(), 1U);
    EXPECT_THAT(run.holes()[0].corrected_mm(),
                IsNearMatrix(Vector2d(version.turned(30, 40) + Vector2d(0.1, 0.2)), kRounding_mm));
  }
}

TEST(AxisVersion, IsTheMachinesWhereTheHeaderHasNone) {
  ReadOptions reading;
  reading.axis_version = 3;
  const std::string rest = "METRIC,LZ\nT1C1.\n%\nT1\nX10.Y20.\nM30\n";
  EXPECT_EQ(run_clean("M48\n" + rest, reading).holes().at(0).nominal_mm(), Vector2d(-20, 10));
  EXPECT_EQ(run_clean("M48\nVER,1\n" + rest, reading).holes().at(0).nominal_mm(), Vector2d(10, 20));
  EXPECT_EQ(run_clean("M71\nT1\nX10.Y20.\nM30\n", reading).holes().at(0).nominal_mm(),
            Vector2d(-20, 10));
}

TEST(AxisVersion, ThereAreEight) {
  for (const char* version : {"VER,0", "VER,9", "VER,X"}) {
    EXPECT_THAT(run_program("M48\n" + std::string(version) + "\nMETRIC,LZ\n%\nM30\n").diagnostics,
                Contains(AllOf(StartsWith("p.exc:2:"), HasSubstr("error[argument-invalid]"))))
        << version;
  }
}

}  // namespace
}  // namespace panelcal
