// SPDX-License-Identifier: Apache-2.0

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::inch_leading_zeros;
using test::IsNearMatrix;
using test::metric;
using test::ProgramRun;
using test::run_program;

constexpr double kRounding_inch = 1e-12;

using Lines = std::vector<std::string>;

Lines executed(std::string_view metric_body, const WalkOptions& options = {}) {
  const ProgramRun run = run_program(metric(metric_body), options);
  EXPECT_FALSE(run.has_errors) << run.diagnostics.front();
  return run.executed.lines();
}

std::vector<Vector2d> inch_holes(std::string_view body) {
  const ProgramRun run = run_program(inch_leading_zeros("T1\n" + std::string(body) + "M30\n"));
  EXPECT_FALSE(run.has_errors) << run.diagnostics.front();
  return test::nominal_inch(run);
}

void expect_places(const std::vector<Vector2d>& places, const std::vector<Vector2d>& expected) {
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_THAT(places[i], IsNearMatrix(expected[i], kRounding_inch)) << "hole " << i;
  }
}

// --- coordinates ---------------------------------------------------------------------------------

TEST(Interpreter, ManualAbsoluteAndIncrementalTable) {
  const std::vector<Vector2d> places = {{0, 0}, {0, 1}, {0, 2}, {1.2, 3.2}, {2.4, 4.4}, {3.4, 4.4}};
  expect_places(inch_holes("XY\nY01\nY02\nX012Y032\nX024Y044\nX034\n"), places);
  expect_places(inch_holes("G91\nXY\nY01\nY01\nX012Y012\nX012Y012\nX01\n"), places);
}

TEST(Interpreter, IciInTheHeaderIsIncremental) {
  const ProgramRun run = run_program("M48\nINCH,LZ\nICI,ON\nT1C.04\n%\nT1\nX01Y01\nX01\nM30\n");
  expect_places(test::nominal_inch(run), {{1, 1}, {2, 1}});
}

TEST(Interpreter, G90AndG91ChangeTheModeBetweenBlocks) {
  expect_places(inch_holes("X01Y01\nG91\nX01Y01\nG90\nX05\n"), {{1, 1}, {2, 2}, {5, 2}});
}

TEST(Interpreter, IncrementalAccumulatorsAreClearedAfterM08) {
  expect_places(inch_holes("G91\nX01Y01\nM25\nX01\nM01\nM02X10\nM08\nX02Y02\n"),
                {{1, 1}, {2, 1}, {12, 1}, {2, 2}});
}

TEST(Interpreter, AnAxisNeverGivenIsZero) {
  expect_places(inch_holes("X01\nY02\n"), {{1, 0}, {1, 2}});
}

// --- CNC-7 manual, Repeat Hole -------------------------------------------------------------------

TEST(RepeatHole, ManualExamples) {
  expect_places(inch_holes("XY\nR03Y1.5\n"), {{0, 0}, {0, 1.5}, {0, 3}, {0, 4.5}});
  const auto row = inch_holes("XY\nR9X001\n");
  ASSERT_EQ(row.size(), 10U);
  EXPECT_THAT(row[9], IsNearMatrix(Vector2d(0.9, 0), kRounding_inch));
  const auto sloped = inch_holes("XY\nR20X00075Y00103\n");
  ASSERT_EQ(sloped.size(), 21U);
  EXPECT_THAT(sloped[20], IsNearMatrix(Vector2d(1.5, 2.06), kRounding_inch));
  const auto fine = inch_holes("XY\nR200X000075\n");
  ASSERT_EQ(fine.size(), 201U);
  EXPECT_THAT(fine[200], IsNearMatrix(Vector2d(1.5, 0), kRounding_inch));
  const auto many = inch_holes("XY\nR4000X0009\n");
  ASSERT_EQ(many.size(), 4001U);
  EXPECT_THAT(many[4000], IsNearMatrix(Vector2d(360, 0), 1e-10));
}

TEST(RepeatHole, GoesOnFromTheLastHoleRepeated) {
  expect_places(inch_holes("XY\nR2X01\nR1Y01\nX05\n"), {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {5, 1}});
}

TEST(RepeatHole, TakesItsStepsAsDistancesInBothModes) {
  expect_places(inch_holes("X01Y01\nG91\nR2X01\n"), {{1, 1}, {2, 1}, {3, 1}});
}

TEST(RepeatHole, KeepsItsPlaceOverAToolChange) {
  expect_places(inch_holes("X01Y01\nT2\nR1X01\n"), {{1, 1}, {2, 1}});
}

TEST(RepeatHole, ManualSampleProgramLines128To132) {
  const auto places = inch_holes("X016Y046\nR4X.1Y.1\nR4X.1Y-.1\nR4X-.1Y-.1\nR3X-.1Y.1\n");
  ASSERT_EQ(places.size(), 16U);
  EXPECT_THAT(places[4], IsNearMatrix(Vector2d(2, 5), kRounding_inch));
  EXPECT_THAT(places[8], IsNearMatrix(Vector2d(2.4, 4.6), kRounding_inch));
  EXPECT_THAT(places[12], IsNearMatrix(Vector2d(2, 4.2), kRounding_inch));
  EXPECT_THAT(places[15], IsNearMatrix(Vector2d(1.7, 4.5), kRounding_inch));
}

// --- tools ---------------------------------------------------------------------------------------

TEST(Interpreter, PassesToolChangesWithTheirCompensationIndex) {
  EXPECT_EQ(
      executed("T0102\nX1.Y1.\nT0\nM30\n"),
      (Lines{"5 header_end", "6 tool 1 index 2", "7 drill 1 (1, 1)", "8 tool 0", "9 end rewind"}));
}

TEST(Interpreter, TheHeadersToolDataRuleOverTheBodys) {
  const ProgramRun run = run_program(metric("T1C3.0F2\nX1.Y1.\nM30\n"));
  ASSERT_EQ(run.executed.tools().size(), 1U);
  EXPECT_EQ(run.executed.tools()[0].diameter, mm(1));
  EXPECT_EQ(run.executed.tools()[0].infeed, mm_per_s(200));  // the header says nothing of it
  EXPECT_EQ(run.diagnostics, Lines{"p.exc:6:1: warning[tool-data-ignored]"});
}

TEST(Interpreter, AToolThatTheHeaderDoesNotDefineIsWarnedOfOnce) {
  const ProgramRun run = run_program(metric("T3\nX1.Y1.\nT1\nX2.Y1.\nT3\nX3.Y1.\nM30\n"));
  EXPECT_EQ(run.diagnostics, Lines{"p.exc:6:1: warning[tool-undefined]"});
}

// --- zero, units, messages, settings, end --------------------------------------------------------

TEST(Interpreter, G93SetsWorkZeroRelativeToAbsoluteZero) {
  WalkOptions options;
  options.absolute_zero = position_mm<frame::Machine>(1000, 2000);
  options.work_zero = position_mm<frame::Machine>(100, 200);
  EXPECT_EQ(executed("T1\nX1.Y2.\nG93X10.Y20.\nX1.Y2.\nM30\n", options),
            (Lines{"5 header_end",
                   "6 tool 1",
                   "7 drill 1 (1101, 2202)",
                   "8 work zero (1110, 2220)",
                   "9 drill 1 (1111, 2222)",
                   "10 end rewind"}));
}

TEST(Interpreter, StopCoordinatesAreRelativeToAbsoluteZero) {
  WalkOptions options;
  options.absolute_zero = position_mm<frame::Machine>(1000, 2000);
  options.work_zero = position_mm<frame::Machine>(100, 200);
  EXPECT_EQ(executed("G93X10.Y20.\nM30X1.Y2.\n", options).back(), "7 end rewind (1001, 2002)");
  EXPECT_EQ(run_program(metric("M00Y2.\n"), options).diagnostics,
            Lines{"p.exc:6:4: error[coordinate-missing]"});
  EXPECT_EQ(executed("M00\n").back(), "6 end");
}

TEST(Interpreter, M08M30EndsSectionAndProgramInOneBlock) {
  const Lines plain = executed("T1\nM25\nX1.Y1.\nM01\nM02X1.\nM08\nM30\n");
  const Lines joined = executed("T1\nM25\nX1.Y1.\nM01\nM02X1.\nM08M30\n");
  EXPECT_EQ(joined.back(), "11 end rewind");
  EXPECT_EQ(Lines(plain.begin(), plain.end() - 1), Lines(joined.begin(), joined.end() - 1));
}

TEST(Interpreter, M71AndM72ChangeTheUnitBeforeTheFirstCoordinate) {
  const ProgramRun to_inch = run_program(metric("M72\nT1\nX01Y02\nM30\n"));
  EXPECT_EQ(to_inch.holes().at(0).nominal_mm(), Vector2d(25.4, 50.8));
  const ProgramRun to_metric = run_program("M71\nT1\nX001Y002\nM30\n");
  EXPECT_EQ(to_metric.holes().at(0).nominal_mm(), Vector2d(1, 2));
}

TEST(Interpreter, ReadsWhatAProgramLeavesOpenAsTheLastSettingHasIt) {
  const ReadOptions trailing{.last_format = {.zeros = Zeros::TrailingKept}};
  const ProgramRun run = run_program("M72\nT1\nX01000Y2000\nM30\n", {}, trailing);
  EXPECT_EQ(run.diagnostics, Lines{});
  EXPECT_EQ(run.holes().at(0).nominal_inch(), Vector2d(0.1, 0.2));
  const ProgramRun stated =
      run_program("M48\nMETRIC,LZ\nT1C1.0\n%\nT1\nX01Y02\nM30\n", {}, trailing);
  EXPECT_EQ(stated.holes().at(0).nominal_mm(), Vector2d(10, 20));
}

TEST(Interpreter, CommentsOfTheBodyContradictNeitherUnitNorZeros) {
  for (const char* comment : {"; Format : 3.3 / Absolute / Inch / Trailing",
                              ";FORMAT={3:3/ inch}",
                              "; Format : 3.3 / Absolute / MM / Leading"}) {
    EXPECT_EQ(run_program(metric(std::string("T1\n") + comment + "\nX1.Y1.\nM30\n")).diagnostics,
              Lines{"p.exc:7:1: error[argument-invalid]"})
        << comment;
  }
}

/// A control knows steps by G91 and ICI alone, so that a comment is no order.
TEST(Interpreter, CommentsOfTheBodyDoNotContradictTheKindOfCoordinates) {
  constexpr const char* kSteps = ";FORMAT={-:-/ incremental}\n";
  constexpr const char* kPlaces = ";FORMAT={-:-/ absolute}\n";
  const auto run = [](const std::string& body) {
    return run_program(metric("T1\n" + body + "M30\n"));
  };
  const auto last_hole = [&](const std::string& body) {
    const ProgramRun program = run(body);
    EXPECT_EQ(program.diagnostics, Lines{}) << body;
    return Vector2d(program.holes().back().nominal_mm());
  };
  const std::string holes = "X1.Y1.\nX2.Y2.\n";
  EXPECT_EQ(run(kSteps + holes).diagnostics, Lines{"p.exc:7:1: error[argument-invalid]"});
  EXPECT_EQ(run("G91\n" + (kPlaces + holes)).diagnostics,
            Lines{"p.exc:8:1: error[argument-invalid]"});
  EXPECT_EQ(run("G90\n" + (kSteps + holes)).diagnostics,
            Lines{"p.exc:8:1: error[argument-invalid]"});
  EXPECT_EQ(run("X9.Y9.\nX8.Y8.\n" + (kSteps + holes)).diagnostics,
            Lines{"p.exc:9:1: error[argument-invalid]"});
  EXPECT_THAT(run("ICI,ON\n" + (kPlaces + holes)).diagnostics,
              testing::Contains("p.exc:8:1: error[argument-invalid]"));
  // An order behind the comment, or none that matters.
  EXPECT_EQ(last_hole(kSteps + ("G91\n" + holes)), Vector2d(3, 3));
  EXPECT_EQ(last_hole(kSteps + ("G90\n" + holes)), Vector2d(2, 2));
  EXPECT_EQ(last_hole("G91\n" + (kSteps + holes)), Vector2d(3, 3));
  EXPECT_EQ(last_hole(kPlaces + holes), Vector2d(2, 2));
  EXPECT_EQ(last_hole(holes + kSteps), Vector2d(2, 2));
}

TEST(Interpreter, ReadsWhatTheOperatorStatesWhateverTheProgramDoes) {
  const auto forced = parse_format("metric,tz,3.2");
  ReadOptions reading{.forced_format = *forced};
  const auto run = [&](const std::string& text) { return run_program(text, {}, reading); };
  const ProgramRun header = run("M48\nINCH,LZ\nT1C1.0\n%\nT1\nX100Y2000\nM30\n");
  EXPECT_EQ(header.diagnostics, Lines{"p.exc:2:1: warning[format-overridden]"});
  EXPECT_EQ(header.holes().at(0).nominal_mm(), Vector2d(1, 20));
  const ProgramRun body = run("M72\nT1\nX100Y2000\nM30\n");
  EXPECT_EQ(body.diagnostics, Lines{"p.exc:1:1: warning[format-overridden]"});
  EXPECT_EQ(body.holes().at(0).nominal_mm(), Vector2d(1, 20));
  EXPECT_EQ(run("T1\nINCH,LZ\nX100Y2000\nM30\n").diagnostics,
            Lines{"p.exc:2:1: warning[format-overridden]"});
  EXPECT_EQ(run("M48\nMETRIC,TZ\n%\nT1\nX100Y2000\nM30\n").diagnostics, Lines{});
}

TEST(Interpreter, PassesMessagesAndSettingsOnInOrder) {
  EXPECT_EQ(
      run_program("M48\nINCH\nATC,ON\n1/2\n%\nM47,Drill it!\nG05\n1/2\n/\n$uvis,lamp,5\nM30\n")
          .executed.lines(),
      (Lines{"3 setting ATC,ON",
             "4 setting 1/2",
             "5 header_end",
             "6 message Drill it!",
             "7 setting G05",
             "8 setting 1/2",
             "9 setting /",
             "10 setting $uvis,lamp,5",
             "11 end rewind"}));
}

TEST(Interpreter, BlkdDeletesTheBlocksBehindASlash) {
  const ProgramRun run =
      run_program("M48\nMETRIC\nBLKD\nT1C1.\n%\nT1\n/X1.Y1.\nX2.Y2.\n/M30\nX3.Y3.\nM30\n");
  EXPECT_EQ(run.diagnostics, Lines{});
  EXPECT_EQ(run.holes().size(), 2U);
}

TEST(Interpreter, CommentsAndBlankLinesDoNothing) {
  EXPECT_EQ(executed("; X1.Y1.\n\n  \nM30\n"), (Lines{"5 header_end", "9 end rewind"}));
}

// --- the end -----------------------------------------------------------------------------------

/// The diagnostics of a program whose body is this, in a file that is read with
/// --accept-unterminated.
Lines accepting(std::string_view body) {
  return run_program(metric(body), {}, {.accepts_unterminated = true}).diagnostics;
}

TEST(ProgramEnd, IsNeeded) {
  const ProgramRun run = run_program(metric("T1\nX1.Y1.\n"));
  EXPECT_EQ(run.diagnostics, Lines{"p.exc:8: error[end-missing]"});
  EXPECT_TRUE(run.holes().empty());
  EXPECT_EQ(run_program(metric("T1\nX1.Y1.\nM06\n")).diagnostics,
            Lines{"p.exc:9: error[end-missing]"});
}

TEST(ProgramEnd, IsM30OrM00OfWhichOnlyTheCodeItselfNeedsNoLineEnd) {
  for (const char* end : {"M30", "M00", "M30 ", "M30\n", "M00\r", "M0\n", "M30X1.Y1.\n"}) {
    EXPECT_EQ(run_program(metric(std::string("T1\nX1.Y1.\n") + end)).diagnostics, Lines{}) << end;
  }
  for (const char* end : {"M0", "M30X1.Y1.", "M00X1.Y1", "M3", "M", "X1.Y1.", ";"}) {
    EXPECT_THAT(run_program(metric(std::string("T1\nX1.Y1.\n") + end)).diagnostics,
                testing::Contains("p.exc:8: error[end-missing]"))
        << end;
  }
}

TEST(ProgramEnd, MayCloseASection) {
  const std::string body = "T1\nM25\nX1.Y1.\nM01\nM02X5.\nM08M30";
  EXPECT_EQ(run_program(metric(body)).diagnostics, Lines{});
  EXPECT_EQ(run_program(metric(body.substr(0, body.size() - 2) + "00")).diagnostics, Lines{});
  EXPECT_EQ(run_program(metric(body.substr(0, body.size() - 3))).diagnostics,
            Lines{"p.exc:11: error[end-missing]"});
}

TEST(ProgramEnd, MayBeMissingIfThatIsAcceptedAndTheLastLineIsComplete) {
  const ProgramRun run = run_program(metric("T1\nX1.Y1.\n"), {}, {.accepts_unterminated = true});
  EXPECT_EQ(run.diagnostics, Lines{"p.exc:8: warning[end-accepted]"});
  EXPECT_EQ(run.holes().size(), 1U);
  EXPECT_EQ(run.executed.lines().back(), "7 end_accepted");
  EXPECT_EQ(accepting("T1\nX1.Y1.\nM30\n"), Lines{});
  EXPECT_EQ(accepting("T1\nX1.Y1."), Lines{"p.exc:7: error[end-missing]"});
  EXPECT_EQ(accepting("T1\nX1.Y1.\nM0"), Lines{"p.exc:8: error[end-missing]"});
}

TEST(ProgramEnd, IsNotAcceptedInsideWhatIsOpen) {
  EXPECT_EQ(run_program("", {}, {.accepts_unterminated = true}).diagnostics,
            Lines{"p.exc:1: error[end-missing]"});
  EXPECT_EQ(run_program("\n \n", {}, {.accepts_unterminated = true}).diagnostics,
            Lines{"p.exc:1: error[end-missing]"});
  const auto first = [](std::string_view body) { return accepting(body).front(); };
  EXPECT_EQ(first("T1\nM25\nX1.Y1.\nM01\n"), "p.exc:7:1: error[repeat-unclosed]");
  EXPECT_EQ(first("T1\nG00X1.Y1.\nM15\nG01X2.\n"), "p.exc:10: error[tool-plunged]");
  EXPECT_EQ(first("T1\nG82\nX1.Y1.\n"), "p.exc:9:1: error[cycle-unfinished]");
  EXPECT_EQ(first("G34,1\nG36X1.Y1.\n"), "p.exc:8:1: error[series-unfinished]");
  EXPECT_EQ(first("M45,ONE\\\n"), "p.exc:6:1: error[argument-invalid]");
}

TEST(Interpreter, TextBehindTheEndIsWarnedOfOnce) {
  const ProgramRun run = run_program(metric("T1\nM30\n\n%\nX1.Y1.\nX2.Y2.\n"));
  EXPECT_EQ(run.diagnostics, Lines{"p.exc:10:1: warning[text-after-end]"});
  EXPECT_TRUE(run.holes().empty());
}

}  // namespace
}  // namespace panelcal
