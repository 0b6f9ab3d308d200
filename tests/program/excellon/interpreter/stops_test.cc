// SPDX-License-Identifier: Apache-2.0
// Stops, dwells, messages and events: CNC-7 manual, Stop Commands, Operator Message, Long Operator
// message, Setup Commands, Rewind Stop.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::metric;
using test::ProgramRun;
using test::run_program;
using test::says;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Lines = std::vector<std::string>;

Lines executed(std::string text, const WalkOptions& options = {}) {
  const ProgramRun run = run_program(std::move(text), options);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run.executed.lines();
}

/// The dwell of `block` behind a header that takes `units` lines of its own.
std::string dwell_of(const std::string& units, const std::string& block) {
  for (const std::string& line : executed("M48\n" + units + "\n%\n" + block + "\nM30\n")) {
    if (line.starts_with("4 dwell ")) return line.substr(8);
  }
  return "none";
}

// --- CNC-7 manual: Variable Dwell ----------------------------------------------------------------

TEST(Dwell, ManualExampleIsOneSecond) {
  EXPECT_EQ(dwell_of("INCH,LZ", "G04X001"), "1");
}

TEST(Dwell, ManualSampleProgramLine54IsFiveSeconds) {
  EXPECT_EQ(dwell_of("INCH,LZ", "G04X005"), "5");
}

TEST(Dwell, IsAMillisecondPerIncrement) {
  EXPECT_EQ(dwell_of("INCH,LZ", "G04X0015"), "1.5");  // 0.15 inch, 1500 increments of 0.0001
  EXPECT_EQ(dwell_of("INCH,TZ", "G04X1500"), "1.5");
  EXPECT_EQ(dwell_of("INCH,LZ", "G04X.15"), "1.5");
  EXPECT_EQ(dwell_of("METRIC,LZ", "G04X0015"), "1.5");          // 1.5 mm, increments of 0.001
  EXPECT_EQ(dwell_of("METRIC,LZ,0000.00", "G04X0015"), "1.5");  // 15 mm, increments of 0.01
  EXPECT_EQ(dwell_of("METRIC,LZ,000.00", "G04X015"), "1.5");    // the same
}

TEST(Dwell, TheManualsLimitsThemselvesAreInside) {
  EXPECT_EQ(dwell_of("INCH,TZ", "G04X1000"), "1");
  EXPECT_EQ(dwell_of("INCH,TZ", "G04X10000"), "10");
}

TEST(Dwell, BeyondTheLimitsOrMissingIsTenSeconds) {
  for (const char* block : {"G04X999", "G04X1", "G04X10001", "G04X20000", "G04X0", "G04"}) {
    EXPECT_EQ(dwell_of("INCH,TZ", block), "10") << block;
  }
}

// --- CNC-7 manual: Stop Commands -----------------------------------------------------------------

WalkOptions two_zeros() {
  WalkOptions options;
  options.absolute_zero = position_mm<frame::Machine>(1000, 2000);
  options.work_zero = position_mm<frame::Machine>(100, 200);
  return options;
}

TEST(Stops, CoordinatesAreRelativeToAbsoluteZero) {
  const Lines lines = executed(metric("T1\nM09X1.Y2.\nM06X3.Y4.\nM30X5.Y6.\n"), two_zeros());
  EXPECT_THAT(lines,
              AllOf(Contains("7 inspection (1001, 2002)"),
                    Contains("8 optional (1003, 2004)"),
                    Contains("9 end rewind (1005, 2006)")));
  EXPECT_EQ(executed(metric("M00X5.Y6.\n"), two_zeros()).back(), "6 end (1005, 2006)");
}

TEST(Stops, WithoutCoordinatesHaveNoPlace) {
  EXPECT_THAT(executed(metric("M09\nM06\nM30\n"), two_zeros()),
              AllOf(Contains("6 inspection"), Contains("7 optional"), Contains("8 end rewind")));
  EXPECT_EQ(executed(metric("M00\n")).back(), "6 end");
}

TEST(Stops, DoNotDrill) {
  EXPECT_TRUE(run_program(metric("T1\nM09X1.Y2.\nM06X3.Y4.\nM30X5.Y6.\n")).holes().empty());
}

TEST(Stops, AreNotMovedByZeroSetsNorByStepAndRepeat) {
  EXPECT_THAT(executed(metric("T1\nG93X10.Y20.\nM25\nX1.Y1.\nM09X1.Y2.\nM01\nM02X50.M80\nM08\n"
                              "M30\n"),
                       two_zeros()),
              AllOf(Contains("10 inspection (1001, 2002) [0]"),
                    Contains("10 inspection (1001, 2002) [1]")));
}

TEST(Stops, AreNotMovedByCorrections) {
  test::FunctionSource panel = test::shifted_by(0.1, 0.2);
  const ProgramRun run =
      run_program(metric("G34,1\nT1\nG35X1.Y1.\nM09X1.Y2.\nM30\n"), two_zeros(), panel);
  EXPECT_THAT(run.executed.lines(), Contains("9 inspection (1001, 2002)"));
}

TEST(Stops, APercentThatEndsTheHeaderStops) {
  EXPECT_THAT(executed("M48\nMETRIC,LZ\nATC,ON\n%\nM30\n"), Contains("4 header_end"));
}

TEST(Stops, M95EndsTheHeaderWithoutAStop) {
  EXPECT_THAT(executed("M48\nMETRIC,LZ\nATC,ON\nM95\nM30\n"),
              Not(Contains(HasSubstr("header_end"))));
}

TEST(Stops, APercentInTheBodyBeginsAPattern) {
  const Lines lines =
      executed("M48\nMETRIC,LZ\nT1C1.\nM95\nT1\n%\nX1.Y1.\nM01\nM02X9.\nM08\nM30\n");
  EXPECT_THAT(lines, Not(Contains(HasSubstr("header_end"))));
  EXPECT_THAT(lines, Contains("7 drill 1 (10, 1) [1]"));
}

// --- CNC-7 manual: Operator Message, Long Operator message ---------------------------------------

TEST(Messages, ManualSampleProgramLine26) {
  EXPECT_THAT(executed(metric("M47,DRILL DEMO\nM30\n")), Contains("6 message DRILL DEMO"));
}

TEST(Messages, ALongMessageGoesOnBehindABackslash) {
  const Lines lines =
      executed(metric("M45,BACKUP 2 MM\\\nENTRY FOIL\\\nTHEN START\nM47,GO\nM30\n"));
  EXPECT_THAT(
      lines,
      AllOf(Contains("6 message BACKUP 2 MM\nENTRY FOIL\nTHEN START"), Contains("9 message GO")));
}

TEST(Messages, ALongMessageMayHaveOneLine) {
  EXPECT_THAT(executed(metric("M45,BACKUP 2 MM\nM30\n")), Contains("6 message BACKUP 2 MM"));
}

TEST(Messages, LinesOfALongMessageAreNeverCommands) {
  const ProgramRun run = run_program(metric("T1\nM45,WRITE\\\nM30\\\nX1.Y1.\nX2.Y2.\nM30\n"));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.executed.lines(), Contains("7 message WRITE\nM30\nX1.Y1."));
}

TEST(Messages, LongerThanTheControlShowsAreWarnedOfAndPassedOn) {
  const std::string twenty(20, 'A');
  const std::string seventy_eight(78, 'B');
  const ProgramRun fits =
      run_program(metric("M47," + twenty + "\nM45,FIRST\\\n" + seventy_eight + "\nM30\n"));
  EXPECT_THAT(fits.diagnostics, Each(Not(HasSubstr("message-too-long"))));
  const ProgramRun long_47 = run_program(metric("M47," + twenty + "A\nM30\n"));
  EXPECT_THAT(long_47.diagnostics, Contains(says(6, "warning[message-too-long]")));
  EXPECT_THAT(long_47.executed.lines(), Contains("6 message " + twenty + "A"));
  const ProgramRun long_45 = run_program(metric("M45,FIRST\\\n" + seventy_eight + "B\nM30\n"));
  EXPECT_THAT(long_45.diagnostics, Contains(HasSubstr("warning[message-too-long]")));
  EXPECT_THAT(long_45.executed.lines(), Contains("6 message FIRST\n" + seventy_eight + "B"));
}

// --- events that are passed on -------------------------------------------------------------------

TEST(Events, ArePassedOnAsWritten) {
  EXPECT_THAT(executed(metric("M18\nM19\nM19,123456\nM62\nM63\nM96,2\nM96,OFF\nM30\n")),
              AllOf(Contains("6 function tool_tip_check M18"),
                    Contains("7 function binary_map M19"),
                    Contains("8 function binary_map M19,123456"),
                    Contains("9 function peck_on M62"),
                    Contains("10 function peck_off M63"),
                    Contains("11 function spindle_group M96,2"),
                    Contains("12 function spindle_group M96,OFF")));
}

TEST(Events, ASpindleGroupIsANumberOrOff) {
  for (const char* block : {"M96", "M96,X"}) {
    EXPECT_THAT(run_program(metric(block + std::string("\nM30\n"))).diagnostics,
                Contains(says(6, "error[")))
        << block;
  }
}

TEST(Events, HappenInEveryCopy) {
  EXPECT_THAT(executed(metric("T1\nM25\nM62\nX1.Y1.\nM63\nM01\nM02X9.\nM08\nM30\n")),
              AllOf(Contains("8 function peck_on M62 [0]"),
                    Contains("8 function peck_on M62 [1]"),
                    Contains("10 function peck_off M63 [1]")));
}

TEST(Events, AutocalibrationIsPassedOnWithAWarning) {
  const ProgramRun run = run_program(metric("T1\nG39X1.Y2.\nX5.Y5.\nM30\n"));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(run.diagnostics, Contains(says(7, "warning[calibration-not-performed]")));
  EXPECT_THAT(run.executed.lines(), Contains("7 autocalibration (1, 2)"));
  EXPECT_EQ(run.holes().size(), 1U);
}

}  // namespace
}  // namespace panelcal
