// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 6: subprograms of offset lines alone.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using test::expect_places;
using test::format_5000;
using test::hole_places;
using test::joined;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::shifted;
using test::SubprogramFolder;
using testing::ElementsAre;
using testing::HasSubstr;

/// "Mixing working blocks (drilling/routing) and offset blocks in subroutines is not allowed":
/// offset blocks alone are. "These values are added to all coordinates of the subprogram."
TEST(ManualSubprogramOfOffsets, OffsetsTheSectionThatCallsIt) {
  SubprogramFolder folder;
  folder.with("PANEL.SS5",
              "@PANEL\nXYM50\n(COLUMNS)\nX10.YM50\nX20.Y5.M60\n@ROW\nX100.YM50V2\nX300.YM50W3\n");
  const auto places_of = [&](const std::string& body) {
    return hole_places(run_5000(body, {}, folder.reading()));
  };
  const Places at_zero = {{1, 2}, {11, 2}, {18, 6}};
  const std::vector<std::string> same = {"X1.Y2.T1M31\nM99,PANEL\nM30\n",
                                         "X1.Y2.T1M31\nM30M99,PANEL\n",
                                         "X1.Y2.T1M31\nXYM99,PANEL\nM30\n",
                                         "X1.Y2.T1\nM99,PANEL\n",
                                         "X1.Y2.T1M31\nXYM50\nX10.YM50\nX20.Y5.M60M30\n"};
  for (const std::string& body : same) {
    SCOPED_TRACE(body);
    expect_places(places_of(body), at_zero);
  }
  expect_places(places_of("X1.Y2.T1M31\nX100.Y50.M99,PANEL\nM30\nX7.Y8.\n"),
                joined(shifted(at_zero, {100, 50}), {{7, 8}}));
  // Two layouts and an offset line; rows of patterns move as well.
  expect_places(places_of("X1.Y2.T1M31\nX50.M50\nM99,PANEL\nY1.M99,ROW\nM30\n"),
                joined(joined({{51, 2}}, at_zero), {{101, 3}, {201, 3}, {301, 3}}));
  // A panel of panels: the inner section's copies are repeated by the outer one's.
  expect_places(places_of("M31\nX1.Y2.T1M31\nXYM50\nXY1.M50M30\nM99,ROW\nM30\n"),
                {{101, 2}, {101, 3}, {201, 2}, {201, 3}, {301, 2}, {301, 3}});
}

TEST(ManualSubprogramOfOffsets, IsRefusedWhereItsMeaningIsOpen) {
  SubprogramFolder folder;
  folder.with("PANEL.SS5",
              "@PANEL\nXYM50\nX10.YM50\n@CLOSING\nX10.YM50M30\n@OPEN\nXYM50V2\n@HALF\nXYM50X\n"
              "@BOTH\nX1.Y1.\nXYM50\n@OTHER\nM99,PANEL\n");
  struct Refusal {
    std::string body;
    std::string start;  ///< of the only diagnostic
  };
  const std::vector<Refusal> refusals = {
      {"X1.Y2.T1M31\nM99,PANEL\nX5.Y5.\nM30\n", "p.exc:4:1: error[section-mixed]"},
      {"X1.Y2.T1M31\nX1.T2M99,PANEL\nM30\n", "p.exc:3:4: error[argument-invalid]"},
      {"X1.Y2.T1M31\nXYM50V2\nM99,PANEL\nM30\n", "p.exc:3:1: error[argument-invalid]"},
      {"X1.Y2.T1M31\nX1.Y1.G91\nX5.M99,PANEL\nM30\n", "p.exc:4:1: error[argument-invalid]"},
      {"X1.Y2.T1M31\nM30\nM99,PANEL\n", "p.exc:4:1: error[section-mixed]"},
      {"M99,PANEL\nX1.Y2.T1\n", "p.exc:2:1: error[section-mixed]"},
      {"X1.Y2.T1M31\nM99,CLOSING\n", "PANEL.SS5:5:1: error[section-mixed]"},
      {"X1.Y2.T1M31\nM99,OPEN\nM30\n", "PANEL.SS5:7:1: error[argument-invalid]"},
      {"X1.Y2.T1M31\nM99,BOTH\nM30\n", "PANEL.SS5:12:1: error[section-mixed]"},
      {"X1.Y2.T1M31\nM99,OTHER\nM30\n", "PANEL.SS5:14:1: error[section-mixed]"},
  };
  for (const Refusal& refusal : refusals) {
    SCOPED_TRACE(refusal.body);
    const ProgramRun run = run_program(format_5000(refusal.body), {}, folder.reading());
    EXPECT_THAT(run.diagnostics, ElementsAre(HasSubstr(refusal.start)));
  }
}

TEST(ManualSubprogramOfOffsets, ThatIsCutOffIsRefused) {
  SubprogramFolder folder;
  folder.with("PANEL.SS5", "@PANEL\nXYM50\nX10.YM50");
  const ProgramRun run =
      run_program(format_5000("X1.Y2.T1M31\nM99,PANEL\nM30\n"), {}, folder.reading());
  EXPECT_THAT(run.diagnostics, ElementsAre(HasSubstr("PANEL.SS5:3: error[end-missing]")));
}

/// Six levels, "calling the subprogram is counted as one nesting depth".
TEST(ManualSubprogramOfOffsets, CountsAsALevel) {
  SubprogramFolder folder;
  folder.with("PANEL.SS5", "@PANEL\nXYM50\nX10.YM50\n");
  const auto nested = [&](std::string brackets, std::string closing) {
    return run_program(format_5000("X1.Y2.T1" + brackets + "\nM99,PANEL\nM30\n" + closing + "\n"),
                       {},
                       folder.reading());
  };
  expect_places(hole_places(nested("M31M31M31M31M31", "M30M30M30M30")), {{1, 2}, {11, 2}});
  EXPECT_THAT(nested("M31M31M31M31M31M31", "M30M30M30M30M30").diagnostics,
              ElementsAre(HasSubstr("p.exc:3:1: error[nesting-too-deep]")));
}

}  // namespace
}  // namespace panelcal
