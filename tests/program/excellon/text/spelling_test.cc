// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/spelling.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using Texts = std::vector<std::string>;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Respelled {
  std::string text;
  Texts diagnostics;
};

/// The text in the manual's characters, also where it has no others.
Respelled respelled(const std::string& text) {
  DiagnosticLog log;
  Respelled out{respell(text, Reporter("p.exc", log)).text, {}};
  out.diagnostics = test::briefs(log);
  if (out.text.empty()) out.text = text;
  EXPECT_EQ(out.text.size(), text.size()) << "places must stay";
  return out;
}

void expect_as_it_is(const std::string& text) {
  const Respelled out = respelled(text);
  EXPECT_EQ(out.text, text);
  EXPECT_THAT(out.diagnostics, IsEmpty()) << text;
}

TEST(Spelling, SmallLettersBecomeCapitals) {
  const Respelled out = respelled("m48\nmetric,lz\n%\n  x1.0y2.0\nX3.0\nx4.0\n");
  EXPECT_EQ(out.text, "M48\nMETRIC,LZ\n%\n  X1.0Y2.0\nX3.0\nX4.0\n");
  EXPECT_THAT(out.diagnostics, ElementsAre("p.exc:1:1: warning[notation-accepted]"));
  EXPECT_THAT(respelled("M48\nINCH,lZ\n").diagnostics,
              ElementsAre("p.exc:2:6: warning[notation-accepted]"));
}

/// Blocks of 128 characters are looked at together; what tells may stand anywhere in one.
TEST(Spelling, FindsWhatIsToBeChangedAnywhereInALongText) {
  for (std::size_t n_lines = 0; n_lines < 70; ++n_lines) {
    std::string head;
    for (std::size_t i = 0; i < n_lines; ++i) head += "X123.5\n";
    const std::string tail(500, '\n');
    EXPECT_EQ(respelled(head + "x1.\n" + tail).text, head + "X1.\n" + tail);
    EXPECT_EQ(respelled(head + "X1.;A\n" + tail).text, head + "X1.  \n" + tail);
    EXPECT_EQ(respelled(head + "X1.(A)\n" + tail).text, head + "X1.   \n" + tail);
    EXPECT_EQ(respelled(head + "N1X1.\n" + tail).text, head + "  X1.\n" + tail);
    DiagnosticLog log;
    EXPECT_TRUE(respell(head + "M99,LOGO\n" + tail, Reporter("p.exc", log)).calls_patterns);
    EXPECT_FALSE(respell(head + ")OL?\n" + tail, Reporter("p.exc", log)).calls_patterns);
  }
}

TEST(Spelling, TextsForPeopleAndFilesStay) {
  expect_as_it_is("M48\nM47,Load (2) panels; go\n");
  expect_as_it_is("M97,abc\nM98,d;e\nM99,logo.exc\n");
  expect_as_it_is("M45,first line\\\nsecond; (line)\\\nNext 10\nX1.\n");
  expect_as_it_is("; a comment (all of it)\n  ;x1\n$uvis,search,on\n");
  expect_as_it_is(" /M45,Look at \\\nn1 the (left) board\n");
  EXPECT_EQ(respelled("/M45,one\\\ntwo\nx1.\n").text, "/M45,one\\\ntwo\nX1.\n");
  EXPECT_EQ(respelled("m99,logo\n").text, "M99,logo\n");
  EXPECT_EQ(respelled("m45,one\\\ntwo\\\nthree\nx1.\n").text, "M45,one\\\ntwo\\\nthree\nX1.\n");
}

TEST(Spelling, CommentsBecomeBlanks) {
  const Respelled out = respelled("X1.Y2. ;hole\nX3.(a (b))Y4.\n(all)\n");
  EXPECT_EQ(out.text, "X1.Y2.      \nX3.       Y4.\n     \n");
  EXPECT_THAT(out.diagnostics, ElementsAre("p.exc:1:8: warning[notation-accepted]"));
}

TEST(Spelling, ACommentThatStatesTheFormatIsRefused) {
  const Respelled out = respelled("METRIC ;file_format=4:4\nINCH (FORMAT={-:-/ inch})\n");
  EXPECT_EQ(out.text, "METRIC                 \nINCH                     \n");
  EXPECT_THAT(
      out.diagnostics,
      ElementsAre("p.exc:1:8: error[argument-invalid]", "p.exc:2:6: error[argument-invalid]"));
  for (const char* comment :
       {"(FILE_FORMAT=4:2)", "X2. (File_Format = 3:3)", "X1.;FILE_FORMAT=?"}) {
    EXPECT_THAT(respelled(std::string(comment) + "\n").diagnostics,
                Contains(testing::HasSubstr("error[argument-invalid]")))
        << comment;
  }
}

TEST(Spelling, ACommentThatOnlyHasTheWordFormatIsAComment) {
  for (const char* comment : {"(PLATING INFORMATION)", ";FORMAT 3.3", "(FILE_FORMAT)"}) {
    EXPECT_THAT(respelled(std::string("X1. ") + comment + "\n").diagnostics,
                ElementsAre("p.exc:1:5: warning[notation-accepted]"))
        << comment;
  }
}

TEST(Spelling, ABracketThatIsNotClosedStays) {
  expect_as_it_is("X1.Y2.(1\n");
}

TEST(Spelling, BlockNumbersBecomeBlanks) {
  const Respelled out = respelled("N1 M48\nNCSL,ON\n/N20X1.\nN30\nX2.N4\n");
  EXPECT_EQ(out.text, "   M48\nNCSL,ON\n/   X1.\n   \nX2.N4\n");
  EXPECT_THAT(out.diagnostics, ElementsAre("p.exc:1:1: warning[notation-accepted]"));
  EXPECT_EQ(respelled("n5m47,Tool\n").text, "  M47,Tool\n");
}

TEST(Spelling, NulCharactersAroundTheProgramBecomeBlanks) {
  using namespace std::string_literals;
  const Respelled out = respelled("\0\0\r\n\0M48\nX1.\n\0\0"s);
  EXPECT_EQ(out.text, "  \r\n M48\nX1.\n  ");
  EXPECT_THAT(out.diagnostics, ElementsAre("p.exc:1:1: warning[notation-accepted]"));
  expect_as_it_is("M48\nX1.\0Y1.\nM30\n"s);
}

TEST(Spelling, EachKindIsReportedOnce) {
  EXPECT_THAT(respelled("N1x1. ;a\nN2x2. ;b\n").diagnostics,
              ElementsAre("p.exc:1:1: warning[notation-accepted]",
                          "p.exc:1:7: warning[notation-accepted]",
                          "p.exc:1:3: warning[notation-accepted]"));
}

TEST(Spelling, TheManualsCharactersAreLeftAlone) {
  expect_as_it_is(
      "M48\r\nMETRIC,TZ,000.000\r\nT1C1.0F200S65\r\n%\r\n/X-1.5Y+2\r\nCAN_TEXT_OFF,1\r\n");
  expect_as_it_is("");
}

TEST(Spelling, KnowsWhetherAProgramCallsPatterns) {
  DiagnosticLog log;
  const Reporter reporter("p.exc", log);
  EXPECT_FALSE(respell("; M98\nM48\nINCH,LZ\n%\nT1\nX1.Y1.\nM30\n", reporter).calls_patterns);
  EXPECT_TRUE(respell("T1\nM99,LOGO\nX1.Y1.\nM30\n", reporter).calls_patterns);
  EXPECT_TRUE(respell("t1\nm99,LOGO\nx1.y1.\nM30\n", reporter).calls_patterns);
}

// --- other kinds of text -------------------------------------------------------------------------

/// `LINE: TEXT` that shows it, or that it may be a program.
std::string foreign(const std::string& text) {
  const ForeignText found = find_foreign(text);
  return found.line == 0 ? "a program"
                         : std::to_string(found.line) + ": " + std::string(found.text);
}

TEST(Foreign, ATextWithoutABlockIsNoProgram) {
  EXPECT_EQ(foreign("(kicad_pcb (version 1)\n  (general)\n)\n"), "1: (kicad_pcb (version 1)");
  EXPECT_EQ(foreign("\n; hello\n<?xml version=\"1.0\"?>\n<eagle>\n"), "3: <?xml version=\"1.0\"?>");
  EXPECT_EQ(foreign("G04 layer*\nG01*\nX100Y100D02*\nM02*\n"), "1: G04 layer*");
  EXPECT_EQ(foreign("X-ray of a board\n"), "1: X-ray of a board");
}

TEST(Foreign, APercentThatGoesOnOpensAnotherLanguage) {
  EXPECT_EQ(foreign("%5000\nX1.Y1.T1\n$\n"), "1: %5000");
  EXPECT_EQ(foreign("DEMO\n  %FSLAX24Y24*%\nX1.\n"), "2: %FSLAX24Y24*%");
  EXPECT_EQ(foreign("M48\n%5000\n"), "a program");
  EXPECT_EQ(foreign("%PROG12\nM48\nMETRIC,TZ\n"), "1: %PROG12");
}

TEST(Foreign, OneBlockIsEnough) {
  for (const char* text : {"",
                           "; nothing\n",
                           "%\n",
                           "m48\n",
                           "#\nN10 t1\n",
                           "nonsense\nX1.Y1.\n",
                           "nonsense\nMETRIC, TZ\n",
                           "nonsense\n1/2/3\n",
                           "nonsense\n$uvis,calib\n"}) {
    EXPECT_EQ(foreign(text), "a program") << text;
  }
}

TEST(Foreign, IsOneErrorAndNothingIsWalked) {
  const std::string board = "(kicad_pcb\n  (general)\n)\n";
  const test::ProgramRun run = test::run_program(board);
  EXPECT_THAT(run.diagnostics, ElementsAre("p.exc:1:1: error[not-a-program]"));
}

// --- blocks --------------------------------------------------------------------------------------

Texts briefs_of(const std::string& body) {
  return test::run_program(test::metric(body)).diagnostics;
}

/// What is executed, without line numbers.
Texts steps_of(const std::string& body) {
  const test::ProgramRun run = test::run_program(test::metric(body));
  EXPECT_FALSE(run.has_errors) << run.diagnostics.front();
  Texts steps;
  for (const std::string& line : run.executed.lines()) {
    steps.push_back(line.substr(line.find(' ')));
  }
  return steps;
}

TEST(Spelling, TwoBlocksInALineAreReadOneAfterTheOther) {
  EXPECT_EQ(steps_of("T1X1.Y2.\nX3.M30\n"), steps_of("T1\nX1.Y2.\nX3.\nM30\n"));
  EXPECT_EQ(steps_of("T1C.8X1.Y2.\nM30\n"), steps_of("T1C.8\nX1.Y2.\nM30\n"));
  EXPECT_EQ(steps_of("T1M06\nX1.Y2.\nM00\n"), steps_of("T1\nM06\nX1.Y2.\nM00\n"));
  EXPECT_EQ(steps_of("T1\nG00X1.Y2.\nG05X3.Y2.\nM30\n"),
            steps_of("T1\nG00X1.Y2.\nG05\nX3.Y2.\nM30\n"));
  EXPECT_THAT(briefs_of("T1X1.Y2.\nT2X1.Y2.\nM30\n"),
              testing::Contains("p.exc:6:1: warning[notation-accepted]").Times(1));
}

/// What becomes blanks leaves blocks of all kinds as they are.
TEST(Spelling, BlanksAtTheEndsOfABlockHaveNoMeaning) {
  EXPECT_EQ(steps_of("N1 1/2 ;link\nN2 CAN_TEXT_OFF,1. (x)\nN3 ATC,ON ;a\nN4 T1\nX1.Y2.\nM30\n"),
            steps_of("1/2\nCAN_TEXT_OFF,1.\nATC,ON\nT1\nX1.Y2.\nM30\n"));
}

TEST(Spelling, LinesWithTwoReadingsAreRefused) {
  EXPECT_THAT(briefs_of("T1\nX1.Y2.M30X5.Y5.\nM30\n"),
              testing::Contains(HasSubstr("error[block-not-alone]")));
  EXPECT_THAT(briefs_of("T1M06X1.Y2.\nM30\n"),
              testing::Contains(HasSubstr("error[block-not-alone]")));
  EXPECT_THAT(briefs_of("T1\nG90X1.Y2.\nM30\n"),
              testing::Contains(HasSubstr("error[block-not-alone]")));
}

}  // namespace
}  // namespace panelcal::excellon
