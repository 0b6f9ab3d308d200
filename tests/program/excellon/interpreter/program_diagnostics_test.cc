// SPDX-License-Identifier: Apache-2.0
// The exact words, line and column of what a person is told about a part program.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::metric;
using test::run_program;

using Texts = std::vector<std::string>;

/// A body and the only diagnostic it gives. Body lines count from 8; the columns are in the body.
struct Case {
  std::string body;
  std::string text;
};

Texts diagnostics_of(const std::string& body) {
  WalkOptions options;
  options.max_operations = 1000;
  options.series_size = 2;
  return run_program(metric("G34,1\nT1\n" + body), options).diagnostics;
}

void expect_each(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    EXPECT_EQ(diagnostics_of(one.body + "M30\n"), Texts{"p.exc:" + one.text}) << one.body;
  }
}

TEST(ProgramDiagnostics, Syntax) {
  expect_each({
      {"X1.Y1.#\n", "8:7: error[block-syntax]"},
      {"x1.Y1.\n", "8:1: warning[notation-accepted]"},
      {"123\n", "8:1: error[block-syntax]"},
      {",1\n", "8:1: error[block-syntax]"},
      {"%%\n", "8:1: error[block-syntax]"},
      {"XXXXXXXXXXXXXXXXX\n", "8:17: error[block-syntax]"},
  });
}

TEST(ProgramDiagnostics, Numbers) {
  expect_each({
      {"X1.Y1.2.3\n", "8:5: error[number-malformed]"},
      {"X0.Y0.\n  R2X-\n", "9:6: error[number-malformed]"},
      {"X0.Y1234567\n", "8:5: error[number-too-long]"},
      {"M25\nX1.Y1.\nM01\nM02X1..\nM08\n", "11:5: error[number-malformed]"},
  });
}

TEST(ProgramDiagnostics, HeaderCommandsInTheBody) {
  expect_each({
      {"ATC,ON\nX1.Y1.\n", "8:1: warning[header-word-in-body]"},
      {"ICI,ON\nX1.Y1.\n", "8:1: warning[header-word-in-body]"},
      {"METRIC,TZ\n", "8:1: error[argument-invalid]"},
      {"INCH,LZ\nX1.Y1.\n", "8:1: error[argument-invalid]"},
      {"METRIC,000.00\n", "8:1: error[argument-invalid]"},
      {"VER,1\n", "8:1: error[command-misplaced]"},
      {"R,T\n", "8:1: error[command-misplaced]"},
      {"ZA,X1.Y1.\n", "8:1: error[command-misplaced]"},
      {"M25\nATC,ON\nX1.Y1.\nM01\nM02X1.\nM08\n", "9:1: error[command-misplaced]"},
  });
  EXPECT_EQ(diagnostics_of("METRIC,LZ\nX1.Y1.\nM30\n"), Texts{});
}

/// Without a header, and behind the first block, the unit comes in time before the first place.
TEST(ProgramDiagnostics, UnitAndZerosInTheBody) {
  const auto run = run_program("T1\nMETRIC,TZ\nX1000Y2000\nM30\n");
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:2:1: warning[header-word-in-body]"});
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_EQ(run.holes().front().nominal_mm(), Eigen::Vector2d(1, 2));
  EXPECT_EQ(run_program("T1\nX1.Y2.\nMETRIC,TZ\nM30\n").diagnostics,
            Texts{"p.exc:3:1: error[command-misplaced]"});
}

/// "If you have a command in the header and the exact same command in the part program body, there
/// is no harm done": so it is where the body has stated it, or the header with digits.
TEST(ProgramDiagnostics, UnitAndZerosStatedAgain) {
  const auto run =
      run_program("T1\nMETRIC,TZ\nX1000Y2000\nMETRIC,TZ\nM25\nMETRIC\nX3000Y2000\nM01\nM08\nM30\n");
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:2:1: warning[header-word-in-body]"});
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_EQ(run.holes().back().nominal_mm(), Eigen::Vector2d(3, 2));
  EXPECT_EQ(
      run_program("T1\nMETRIC,TZ\nX1000Y2000\nMETRIC,LZ\nM30\n").diagnostics,
      (Texts{"p.exc:2:1: warning[header-word-in-body]", "p.exc:4:1: error[argument-invalid]"}));
  const std::string digits = "M48\nMETRIC,TZ,000.000\n%\nT1\nX1000Y2000\n";
  EXPECT_EQ(run_program(digits + "METRIC,TZ\nMETRIC\nM30\n").diagnostics, Texts{});
  EXPECT_EQ(run_program(digits + "METRIC,LZ\nM30\n").diagnostics,
            Texts{"p.exc:6:1: error[argument-invalid]"});
  // A header that leaves the zeros open may be followed by what says them.
  const auto open = run_program("M48\nMETRIC\n%\nT1\nMETRIC,TZ\nX1000Y2000\nM30\n");
  ASSERT_FALSE(open.has_errors);
  EXPECT_EQ(open.holes().front().nominal_mm(), Eigen::Vector2d(1, 2));
}

/// "The INCH/METRIC command must be specified before any commands with dimensions."
TEST(ProgramDiagnostics, AUnitBehindNumbersThatItMeasures) {
  EXPECT_EQ(run_program("T1C0.8\nMETRIC,TZ\nX1000Y1000\nM30\n").diagnostics,
            Texts{"p.exc:2:1: error[argument-invalid]"});
  EXPECT_EQ(run_program("T1C.03\nM72\nX1.Y1.\nM30\n").diagnostics, Texts{});
  for (const char* number :
       {"T1C.8", "F200", "G93X1.Y1.", "CAN_TEXT_OFF,1.", "DN,1.5", "$uvis,searcharea,1"}) {
    for (const char* unit : {"METRIC,TZ", "M71"}) {
      const auto run = run_program("T1\n" + std::string(number) + '\n' + unit + "\nX1.Y1.\nM30\n");
      EXPECT_THAT(run.diagnostics, testing::Contains("p.exc:3:1: error[argument-invalid]"))
          << number << ' ' << unit;
    }
  }
  EXPECT_EQ(
      run_program("M48\nT1C0.8\nCP,1,0.8\nZ,X10.0Y10.0\n%\nT1\nM71\nX1.Y1.\nM30\n").diagnostics,
      Texts{"p.exc:7:1: error[argument-invalid]"});
}

/// Settings are passed on as written, and an output states one unit.
TEST(ProgramDiagnostics, ASettingInAnotherUnitThanTheHeaders) {
  EXPECT_THAT(diagnostics_of("M72\nDN,.1\nX1.Y1.\nM30\n"),
              testing::Contains("p.exc:9:1: error[not-supported]"));
  EXPECT_EQ(diagnostics_of("M72\nATC,ON\nX1.Y1.\nM30\n"),
            Texts{"p.exc:9:1: warning[header-word-in-body]"});
}

TEST(ProgramDiagnostics, OptionsThatComeAgain) {
  const std::string head = "M48\nMETRIC,000.000,LZ\nICI,OFF\nT1C1.\n%\nT1\n";
  EXPECT_EQ(run_program(head + "METRIC,LZ\nICI,OFF\nX1.Y1.\nMETRIC\nM30\n").diagnostics, Texts{});
  const auto run = run_program(head + "G91\nX1.Y1.\nICI,OFF\nM30\n");
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:9:1: error[argument-invalid]"});
  EXPECT_THAT(run.texts.front(), testing::HasSubstr("\"ICI,OFF\" behind G91;"));
  EXPECT_EQ(run_program(head + "METRIC\nM72\nMETRIC\nX1.Y1.\nM30\n").diagnostics,
            Texts{"p.exc:9:1: error[argument-invalid]"});
  const auto more = run_program("M48\nINCH\n%\nT1\nINCH,TZ\nX10000Y20000\nM30\n");
  EXPECT_EQ(more.diagnostics, Texts{"p.exc:5:1: warning[header-word-in-body]"});
  EXPECT_EQ(more.holes().front().nominal_inch(), Eigen::Vector2d(1, 2));
}

TEST(ProgramDiagnostics, ZerosBehindNumbersThatTheyTellHowToRead) {
  for (const char* head :
       {"M48\nMETRIC\nT1C00800\n%\nT1\n", "M48\nMETRIC\n%\nT1\nG93X0001Y0001\n"}) {
    const auto run = run_program(std::string(head) + "METRIC,TZ\nX1000Y1000\nM30\n");
    EXPECT_THAT(run.diagnostics, testing::Contains(testing::HasSubstr("error[argument-invalid]")));
    EXPECT_FALSE(run_program(std::string(head) + "METRIC,LZ\nX1000Y1000\nM30\n").has_errors);
  }
  EXPECT_EQ(run_program("M48\nMETRIC\nT1C00800\nMETRIC,TZ\n%\nT1\nX1.Y1.\nM30\n").diagnostics,
            Texts{"p.exc:4:8: error[argument-invalid]"});
}

/// Incremental input from a header command in the body, as by G91.
TEST(ProgramDiagnostics, IncrementalInputBeginsWhereItStands) {
  const auto run = run_program(metric("T1\nX1.Y1.\nICI,ON\nX1.\nICI,ON\nX1.\nM30\n"));
  ASSERT_EQ(run.holes().size(), 3U);
  EXPECT_EQ(run.holes().back().nominal_mm(), Eigen::Vector2d(3, 1));
  EXPECT_EQ(run.diagnostics.size(), 2U);
}

TEST(ProgramDiagnostics, CommentsThatStateOtherDigits) {
  expect_each({
      {";FILE_FORMAT=4:4\nX1.Y1.\n", "8:1: error[argument-invalid]"},
      {"X1.Y1.\n ;FORMAT={2:4/ absolute}\n", "9:1: error[argument-invalid]"},
  });
  EXPECT_EQ(diagnostics_of(";FILE_FORMAT=3:3\n;FORMAT={-:-}\nX1.Y1.\nM30\n"), Texts{});
}

/// Small letters and comments, which are read as capitals and blanks.
TEST(ProgramDiagnostics, QuoteTheLastLinesAsTheyAreWritten) {
  const auto texts = [](const std::string& body) {
    return run_program(metric("T1\n" + body)).texts;
  };
  EXPECT_THAT(texts("X1.Y1.\nM30 (end"),
              testing::Contains(testing::HasSubstr("\"M30 (end\" has no line end")));
  EXPECT_THAT(texts("X2.Y2.;m30"),
              testing::Contains(testing::HasSubstr("\"X2.Y2.;m30\" has no line end")));
  EXPECT_THAT(texts("X2.Y2.\nm30\nx3.y3.\n"), testing::Contains(testing::HasSubstr("\"x3.y3.\"")));
}

TEST(ProgramDiagnostics, ZerosBeyondTheDigitsOfADiameter) {
  const auto run = run_program(
      "M48\nMETRIC,TZ,000.000\nT1C.8\n%\nT2C00001000\nX0001000Y1000\nT3C00001000\nM30\n");
  EXPECT_THAT(run.diagnostics, testing::Contains("p.exc:5:3: warning[notation-accepted]"));
  EXPECT_THAT(run.diagnostics,
              testing::Contains(testing::HasSubstr("[notation-accepted]")).Times(1));
  EXPECT_EQ(run.executed.tools().front().diameter, mm(1));
}

TEST(ProgramDiagnostics, UnknownCommands) {
  expect_each({
      {"G06\n", "8:1: error[command-unknown]"},
      {" M100\n", "8:2: error[command-unknown]"},
      {"Q5\n", "8:1: error[command-unknown]"},
      {"$vis,lamp,1\n", "8:1: error[command-unknown]"},
      {"$uvis,lamb,1\n", "8:7: error[command-unknown]"},
      {" $uvis,foo\n", "8:8: error[command-unknown]"},
  });
}

TEST(ProgramDiagnostics, BlockDelete) {
  expect_each({
      {"/X1.Y1.\n/X2.Y2.\n", "8:1: warning[block-delete-assumed]"},
  });
  EXPECT_EQ(diagnostics_of("//X1.Y1.\nM30\n"),
            (Texts{"p.exc:8:1: warning[block-delete-assumed]", "p.exc:8:2: error[block-syntax]"}));
}

TEST(ProgramDiagnostics, CodesThatBelongInsideABlock) {
  expect_each({
      {"G85X1.Y1.\n", "8:1: error[coordinate-missing]"},
      {"G84X5.\n", "8:1: error[coordinate-missing]"},
      {"G87X1.Y1.Z-1.U2.\n", "8:1: error[coordinate-missing]"},
      {"X1.Y1.G85\n", "8:7: error[coordinate-missing]"},
  });
}

TEST(ProgramDiagnostics, CommandsAtTheWrongPlace) {
  expect_each({
      {"M01\n", "8:1: error[command-misplaced]"},
      {"M08\n", "8:1: error[command-misplaced]"},
      {"X0.Y0.\nR2M02X1.\n", "9:3: error[command-misplaced]"},
      {"X0.Y0.\nM72\n", "9:1: error[command-misplaced]"},
      {"M25\nM72\nM01\nM02X1.\nM08\n", "9:1: error[command-misplaced]"},
      {"M25\nX1.Y1.\nM01\nX2.Y2.\nM08\n", "11:1: error[command-misplaced]"},
  });
}

TEST(ProgramDiagnostics, BlocksThatMustStandAlone) {
  expect_each({
      {"G90X1.Y1.\n", "8:4: error[block-not-alone]"},
      {"X1.Y1.T2\n", "8:7: error[block-not-alone]"},
      {"M47X1.,DRILL\n", "8:4: error[block-not-alone]"},
      {"M25\nX1.Y1.\nM01X2.\nM08\n", "10:4: error[block-not-alone]"},
      {"M25\nX1.Y1.\nM01\nM08T2\n", "11:4: error[block-not-alone]"},
  });
}

TEST(ProgramDiagnostics, ArgumentsBehindACommaThatNobodyReads) {
  expect_each({
      {"X1.Y1.,5\n", "8:7: error[block-not-alone]"},
      {"G35X1.Y1.,5\n", "8:10: error[block-not-alone]"},
      {"X0.Y0.\nR2X1.,5\n", "9:6: error[block-not-alone]"},
      {"G90,5\n", "8:4: error[block-not-alone]"},
      {"M25\nX1.Y1.\nM01,5\nM08\n", "10:4: error[block-not-alone]"},
      {"M25\nX1.Y1.\nM01\nM02X1.,5\nM08\n", "11:7: error[block-not-alone]"},
      {"T2,5\n", "8:3: error[block-not-alone]"},
  });
}

TEST(ProgramDiagnostics, Arguments) {
  expect_each({
      {"X1.X2.\n", "8:4: error[argument-invalid]"},
      {"X0.Y0.\nR0X1.\n", "9:1: error[argument-invalid]"},
      {"G34\n", "8:1: error[argument-invalid]"},
      {"G34,1,2,0,4,.5\n", "8:9: error[argument-invalid]"},
      {"G34,1,-.5\n", "8:7: error[argument-invalid]"},
      {"M50\n", "8:1: error[argument-invalid]"},
      {"M52,0\n", "8:1: error[argument-invalid]"},
      {"$uvis,lamp,dim\n", "8:12: error[argument-invalid]"},
      {"$uvis,insp,0\n", "8:12: error[argument-invalid]"},
      {"$uvis,search,maybe\n", "8:14: error[argument-invalid]"},
      {"$uvis,alg,0\n", "8:11: error[argument-invalid]"},
      {"$uvis,focus,5\n", "8:13: error[argument-invalid]"},
      {"$uvis,calib,5\n", "8:13: error[argument-invalid]"},
      {"M25\nX1.Y1.\nM01\nR0M02X1.\nM08\n", "11:1: error[argument-invalid]"},
      {"M25\nX1.Y1.\nM01\nR2M02\nM08\n", "11:1: error[argument-invalid]"},
      {"M25\nX1.Y1.\nM01\nR2X1.\nM08\n", "11:1: error[argument-invalid]"},
      {"M25\nX1.Y1.\nM01\nM02X1.M60\nM08\n", "11:7: error[argument-invalid]"},
  });
}

TEST(ProgramDiagnostics, WordsGivenTwiceInACopy) {
  expect_each({
      {"M25\nX1.Y1.\nM01\nM02X1.X2.\nM08\n", "11:7: error[argument-invalid]"},
      {"M25\nX1.Y1.\nM01\nM02X1.M80M80\nM08\n", "11:10: error[argument-invalid]"},
  });
}

TEST(ProgramDiagnostics, MissingCoordinates) {
  expect_each({
      {"G35\n", "8:1: error[coordinate-missing]"},
      {"G93X1.\n", "8:1: error[coordinate-missing]"},
      {"X0.Y0.\nR2\n", "9:1: error[coordinate-missing]"},
  });
}

TEST(ProgramDiagnostics, UnclosedSections) {
  const std::string no_m01 = "8:1: error[repeat-unclosed]";
  expect_each({
      {"M25\nX1.Y1.\n", no_m01},
      {"M25\nX1.Y1.\nM25\nX1.Y1.\nM01\nM08\n", no_m01},
      {"M25\nX1.Y1.\nM08\n", no_m01},
  });
  EXPECT_EQ(diagnostics_of("M25\nX1.Y1.\nM01\nM02X1.\n"),
            Texts{"p.exc:8:1: error[repeat-unclosed]"});
}

TEST(ProgramDiagnostics, AHoleBeforeAnyTool) {
  EXPECT_EQ(run_program(metric("X1.Y1.\nX2.Y2.\nM30\n")).diagnostics,
            Texts{"p.exc:6:1: error[tool-missing]"});
  EXPECT_EQ(diagnostics_of("T0\nX1.Y1.\nM30\n"), Texts{"p.exc:9:1: error[tool-missing]"});
}

TEST(ProgramDiagnostics, ATargetBeforeAnyVisionTool) {
  EXPECT_EQ(run_program(metric("G35X1.Y1.\nG35X2.Y2.\nM30\n")).diagnostics,
            Texts{"p.exc:6:1: error[vision-tool-missing]"});
}

TEST(ProgramDiagnostics, OnePassFindsSeveral) {
  EXPECT_EQ(diagnostics_of("G99\nX1.Y1.Q\nM30\n"),
            (Texts{"p.exc:8:1: error[command-unknown]", "p.exc:9:7: error[block-not-alone]"}));
}

TEST(ProgramDiagnostics, OffendingTextIsPrintable) {
  EXPECT_EQ(diagnostics_of("X1.Y1.\x01\nM30\n"), Texts{"p.exc:8:7: error[block-syntax]"});
}

}  // namespace
}  // namespace panelcal
