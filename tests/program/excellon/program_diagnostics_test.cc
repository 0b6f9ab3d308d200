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
      {"X1.Y1.#\n", "8:7: error[block-syntax]: \"#\", expected a letter A to Z"},
      {"x1.Y1.\n", "8:1: error[block-syntax]: \"x\", expected a letter A to Z"},
      {"123\n", "8:1: error[block-syntax]: \"1\", expected a letter A to Z"},
      {",1\n", "8:1: error[block-syntax]: \",1\", expected a command"},
      {"%%\n", "8:1: error[block-syntax]: \"%\", expected a letter A to Z"},
      {"XXXXXXXXXXXXXXXXX\n",
       "8:17: error[block-syntax]: \"X\", expected at most 16 words in a "
       "block"},
  });
}

TEST(ProgramDiagnostics, Numbers) {
  expect_each({
      {"X1.Y1.2.3\n",
       "8:5: error[number-malformed]: \"1.2.3\" is not a number, expected a sign, "
       "digits and at most one decimal point"},
      {"X0.Y0.\n  R2X-\n",
       "9:6: error[number-malformed]: \"-\" is not a number, expected a sign, "
       "digits and at most one decimal point"},
      {"X0.Y1234567\n",
       "8:5: error[number-too-long]: \"1234567\" has too many digits, expected at "
       "most 6 digits (metric 3.3, leading zeros kept)"},
      {"M25\nX1.Y1.\nM01\nM02X1..\nM08\n",
       "11:5: error[number-malformed]: \"1..\" is not a "
       "number, expected a sign, digits and at most one "
       "decimal point"},
  });
}

TEST(ProgramDiagnostics, UnknownCommands) {
  expect_each({
      {"G06\n",
       "8:1: error[command-unknown]: \"G06\" in \"G06\", expected a code of the manual's "
       "table"},
      {" M100\n",
       "8:2: error[command-unknown]: \"M100\" in \"M100\", expected a code of the "
       "manual's table"},
      {"Q5\n", "8:1: error[command-unknown]: \"Q5\", expected X, Y, G, M, T, R, P, F or B"},
      {"$vis,lamp,1\n", "8:1: error[command-unknown]: \"$vis,lamp,1\", expected $uvis,..."},
      {"$uvis,lamb,1\n",
       "8:7: error[command-unknown]: \"lamb\" is no $uvis command, expected "
       "perhaps lamp"},
      {" $uvis,foo\n",
       "8:8: error[command-unknown]: \"foo\" is no $uvis command, expected auto, "
       "box, search, searcharea, entry, insp, focus, lamp, zoom, calib or alg"},
  });
}

TEST(ProgramDiagnostics, BlockDelete) {
  expect_each({
      {"/X1.Y1.\n/X2.Y2.\n",
       "8:1: warning[block-delete-assumed]: \"/X1.Y1.\" is executed, expected BLKD,ON or BLKD,OFF "
       "in the header"},
  });
  EXPECT_EQ(diagnostics_of("//X1.Y1.\nM30\n"),
            (Texts{"p.exc:8:1: warning[block-delete-assumed]: \"//X1.Y1.\" is executed, expected "
                   "BLKD,ON or BLKD,OFF in the header",
                   "p.exc:8:2: error[block-syntax]: \"//X1.Y1.\", expected one slash"}));
}

TEST(ProgramDiagnostics, CodesThatBelongInsideABlock) {
  const std::string expected = ", the first place before the code";
  expect_each({
      {"G85X1.Y1.\n",
       "8:1: error[coordinate-missing]: \"G85\" in \"G85X1.Y1.\", expected X#Y#G85X#Y#" + expected},
      {"G84X5.\n",
       "8:1: error[coordinate-missing]: \"G84\" in \"G84X5.\", expected X#Y#G84X#" + expected},
      {"G87X1.Y1.Z-1.U2.\n",
       "8:1: error[coordinate-missing]: \"G87\" in \"G87X1.Y1.Z-1.U2.\", expected "
       "X#Y#G87X#Y#Z-#U#" +
           expected},
      {"X1.Y1.G85\n",
       "8:7: error[coordinate-missing]: \"G85\" in \"X1.Y1.G85\", expected X#Y#G85X#Y#"},
  });
}

TEST(ProgramDiagnostics, CommandsAtTheWrongPlace) {
  expect_each({
      {"M01\n",
       "8:1: error[command-misplaced]: \"M01\" in \"M01\", expected a step and repeat "
       "section opened by M25"},
      {"M08\n",
       "8:1: error[command-misplaced]: \"M08\" in \"M08\", expected a step and repeat "
       "section opened by M25"},
      {"X0.Y0.\nR2M02X1.\n",
       "9:3: error[command-misplaced]: \"M02\" in \"R2M02X1.\", expected "
       "R#M02 between M01 and M08"},
      {"X0.Y0.\nM72\n",
       "9:1: error[command-misplaced]: \"M72\" in \"M72\", expected the unit "
       "before the first coordinate and outside step and repeat"},
      {"M25\nM72\nM01\nM02X1.\nM08\n",
       "9:1: error[command-misplaced]: \"M72\" in \"M72\", "
       "expected the unit before the first coordinate and outside "
       "step and repeat"},
      {"M25\nX1.Y1.\nM01\nX2.Y2.\nM08\n",
       "11:1: error[command-misplaced]: \"X2.Y2.\" stands "
       "between M01 and M08 of the section opened in line 8, "
       "expected M02, R#M02, M01 or M08"},
  });
}

TEST(ProgramDiagnostics, BlocksThatMustStandAlone) {
  expect_each({
      {"G90X1.Y1.\n",
       "8:4: error[block-not-alone]: \"X1.\" in \"G90X1.Y1.\", expected \"G90\" in "
       "a block by itself"},
      {"X1.Y1.T2\n",
       "8:7: error[block-not-alone]: \"T2\" in \"X1.Y1.T2\", expected only X and Y "
       "here"},
      {"M47X1.,DRILL\n",
       "8:4: error[block-not-alone]: \"X1.\" in \"M47X1.,DRILL\", expected "
       "\"M47\" in a block by itself"},
      {"M25\nX1.Y1.\nM01X2.\nM08\n",
       "10:4: error[block-not-alone]: \"X2.\" in \"M01X2.\", "
       "expected \"M01\" in a block by itself"},
      {"M25\nX1.Y1.\nM01\nM08T2\n",
       "11:4: error[block-not-alone]: \"T2\" in \"M08T2\", expected "
       "M08 alone or with M30"},
  });
}

TEST(ProgramDiagnostics, ArgumentsBehindACommaThatNobodyReads) {
  const std::string end = ", expected no comma in this block";
  expect_each({
      {"X1.Y1.,5\n", "8:7: error[block-not-alone]: \",5\" behind \"X1.\"" + end},
      {"G35X1.Y1.,5\n", "8:10: error[block-not-alone]: \",5\" behind \"G35\"" + end},
      {"X0.Y0.\nR2X1.,5\n", "9:6: error[block-not-alone]: \",5\" behind \"R2\"" + end},
      {"G90,5\n", "8:4: error[block-not-alone]: \",5\" behind \"G90\"" + end},
      {"M25\nX1.Y1.\nM01,5\nM08\n", "10:4: error[block-not-alone]: \",5\" behind \"M01\"" + end},
      {"M25\nX1.Y1.\nM01\nM02X1.,5\nM08\n",
       "11:7: error[block-not-alone]: \",5\" behind \"M02\"" + end},
      {"T2,5\n", "8:3: error[block-not-alone]: \",5\" behind \"T2\"" + end},
  });
}

TEST(ProgramDiagnostics, Arguments) {
  expect_each({
      {"X1.X2.\n",
       "8:4: error[argument-invalid]: \"X2.\" in \"X1.X2.\", expected each letter once"},
      {"X0.Y0.\nR0X1.\n",
       "9:1: error[argument-invalid]: \"R0\" in \"R0X1.\", expected R1 to "
       "R9999"},
      {"G34\n",
       "8:1: error[argument-invalid]: \"G34\", expected G34,v1 or G34,v1,delta or "
       "G34,v1,v2,v3,v4,delta"},
      {"G34,1,2,0,4,.5\n", "8:9: error[argument-invalid]: \"0\", expected a vision tool from 1"},
      {"G34,1,-.5\n",
       "8:7: error[argument-invalid]: \"-.5\", expected the distance of the four "
       "views, above zero"},
      {"M50\n",
       "8:1: error[argument-invalid]: \"M50\" in \"M50\", expected M50,# with the number "
       "of a label"},
      {"M52,0\n",
       "8:1: error[argument-invalid]: \"M52\" in \"M52,0\", expected M52 or M52,# with "
       "a count from 1"},
      {"$uvis,lamp,dim\n", "8:12: error[argument-invalid]: \"dim\", expected a number from 0"},
      {"$uvis,insp,0\n", "8:12: error[argument-invalid]: \"0\", expected a number from 1"},
      {"$uvis,search,maybe\n", "8:14: error[argument-invalid]: \"maybe\", expected on or off"},
      {"$uvis,alg,0\n",
       "8:11: error[argument-invalid]: \"0\", expected "
       "$uvis,alg,algorithm,fiducials"},
      {"$uvis,focus,5\n", "8:13: error[argument-invalid]: \"5\", expected $uvis,focus,x#y#"},
      {"$uvis,calib,5\n", "8:13: error[argument-invalid]: \"5\", expected $uvis,calib alone"},
      {"M25\nX1.Y1.\nM01\nR0M02X1.\nM08\n",
       "11:1: error[argument-invalid]: \"R0\", expected R1 to "
       "R9999"},
      {"M25\nX1.Y1.\nM01\nR2M02\nM08\n",
       "11:1: error[argument-invalid]: \"R2\", expected "
       "R#M02X#Y#"},
      {"M25\nX1.Y1.\nM01\nR2X1.\nM08\n",
       "11:1: error[argument-invalid]: \"R2\", expected "
       "R#M02X#Y# between M01 and M08"},
      {"M25\nX1.Y1.\nM01\nM02X1.M60\nM08\n",
       "11:7: error[argument-invalid]: \"M60\", expected M02 "
       "with X, Y, M70, M80, M90 or T"},
  });
}

TEST(ProgramDiagnostics, WordsGivenTwiceInACopy) {
  expect_each({
      {"M25\nX1.Y1.\nM01\nM02X1.X2.\nM08\n",
       "11:7: error[argument-invalid]: \"X2.\", expected each axis once"},
      {"M25\nX1.Y1.\nM01\nM02X1.M80M80\nM08\n",
       "11:10: error[argument-invalid]: \"M80\", expected each of M70, M80 and M90 once"},
  });
}

TEST(ProgramDiagnostics, MissingCoordinates) {
  expect_each({
      {"G35\n",
       "8:1: error[coordinate-missing]: \"G35\" in \"G35\", expected X and Y of the "
       "target"},
      {"G93X1.\n", "8:1: error[coordinate-missing]: \"G93\" in \"G93X1.\", expected G93X#Y#"},
      {"X0.Y0.\nR2\n", "9:1: error[coordinate-missing]: \"R2\" in \"R2\", expected R#X#Y#"},
  });
}

TEST(ProgramDiagnostics, UnclosedSections) {
  const std::string expected = ", expected M25 ... M01 ... M02 ... M08";
  const std::string no_m01 =
      "8:1: error[repeat-unclosed]: the step and repeat section opened here has no M01" + expected;
  expect_each({
      {"M25\nX1.Y1.\n", no_m01},
      {"M25\nX1.Y1.\nM25\nX1.Y1.\nM01\nM08\n", no_m01},
      {"M25\nX1.Y1.\nM08\n", no_m01},
  });
  EXPECT_EQ(diagnostics_of("M25\nX1.Y1.\nM01\nM02X1.\n"),
            Texts{"p.exc:8:1: error[repeat-unclosed]: the step and repeat section opened here has "
                  "no M08" +
                  expected});
}

TEST(ProgramDiagnostics, AHoleBeforeAnyTool) {
  EXPECT_EQ(run_program(metric("X1.Y1.\nX2.Y2.\nM30\n")).diagnostics,
            Texts{"p.exc:6:1: error[tool-missing]: a hole or rout move comes before any tool was "
                  "taken, expected T#"});
  EXPECT_EQ(diagnostics_of("T0\nX1.Y1.\nM30\n"),
            Texts{"p.exc:9:1: error[tool-missing]: a hole or rout move comes while no tool is "
                  "taken, after T0, expected T#"});
}

TEST(ProgramDiagnostics, ATargetBeforeAnyVisionTool) {
  EXPECT_EQ(run_program(metric("G35X1.Y1.\nG35X2.Y2.\nM30\n")).diagnostics,
            Texts{"p.exc:6:1: error[vision-tool-missing]: G35 measures before any G34, expected "
                  "G34,# with the number of a vision tool"});
}

TEST(ProgramDiagnostics, OnePassFindsSeveral) {
  EXPECT_EQ(diagnostics_of("G99\nX1.Y1.Q\nM30\n"),
            (Texts{"p.exc:8:1: error[command-unknown]: \"G99\" in \"G99\", expected a code of the "
                   "manual's table",
                   "p.exc:9:7: error[block-not-alone]: \"Q\" in \"X1.Y1.Q\", expected only X and Y "
                   "here"}));
}

TEST(ProgramDiagnostics, OffendingTextIsPrintable) {
  EXPECT_EQ(diagnostics_of("X1.Y1.\x01\nM30\n"),
            Texts{"p.exc:8:7: error[block-syntax]: \"\\x01\", expected a letter A to Z"});
}

}  // namespace
}  // namespace panelcal
