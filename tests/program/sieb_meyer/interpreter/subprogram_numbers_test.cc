// SPDX-License-Identifier: Apache-2.0
// Subprograms have no %%: they are read where the program and the control have one reading of them.
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using test::expect_places;
using test::hole_places;
using test::ProgramRun;
using test::run_program;
using test::SubprogramFolder;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const std::string kTable = "$\nT1D1.016\nT2D2.032\n$\n";

ProgramRun in_mm(const std::string& body, const ReadOptions& reading) {
  return run_program("%%5000\n" + body + kTable, {}, reading);
}

/// "Subprograms are loaded": the %% stands in the program alone, and the control is set to inch.
TEST(SubprogramNumbers, RefusesSubprogramsThatMayBeInTheNumbersOfTheControl) {
  SubprogramFolder folder;
  folder.with("S.SS5", "@HOLES\nX1.Y1.\n");
  ReadOptions reading = folder.reading();
  reading.last_format = *parse_format("inch,tz,2.4");
  const std::string body = "X5.Y5.T1\n(A) \nX2.Y1.M99,HOLES\n";
  EXPECT_THAT(in_mm(body, reading).diagnostics, Contains("p.exc:4:7: error[format-ambiguous]"));
  EXPECT_FALSE(in_mm("X5.Y5.T1\n", reading).has_errors);
  reading.forced_format = *parse_format("metric,tz,3.3");
  expect_places(hole_places(in_mm(body, reading)), {{5, 5}, {3, 2}});
}

/// Blanks stand behind the comma in the manual's own "M99, FINAL" (6), and a longer name is
/// another.
TEST(SubprogramNumbers, NamesTheCallOfASubprogramInOpenNumbers) {
  SubprogramFolder folder;
  folder.with("S.SS5", "@HO\nX1.Y1.\n@HOLES\nX1.Y1.\n@MARKED\nX1.Y1.\n")
      .with("A.SS5", "COMMENT\n%%5000\n@A\nX1.Y1.\nX2.Y2.M99, HO\n")
      .with("MARKED.SS5", "%%5000\n@MARKED\nX1.Y1.\n");
  ReadOptions reading = folder.reading();
  reading.last_format = *parse_format("inch,tz,2.4");
  const auto texts = [&](const std::string& body) { return in_mm(body, reading).texts; };
  const auto refused = [](const std::string& place) {
    return Contains(HasSubstr(place + ": error[format-ambiguous]"));
  };
  EXPECT_THAT(texts("X5.Y5.T1\nX1.Y1.M99, HO\n"), refused("p.exc:3:7"));
  EXPECT_THAT(texts("X5.Y5.T1\nX1.Y1. M99 ,\tHO \n"), refused("p.exc:3:8"));
  const auto both = texts("X5.Y5.T1\nX1.Y1.M99,HOLES\nX2.Y2.M99,HO\n");
  EXPECT_THAT(both, refused("p.exc:3:7"));
  EXPECT_THAT(both, refused("p.exc:4:7"));
  // Called by a subprogram alone, which states its format.
  EXPECT_THAT(texts("X5.Y5.T1\nX1.Y1.M99,A\n"), refused("A.SS5:5:7"));
  EXPECT_FALSE(in_mm("X5.Y5.T1\nX1.Y1.M99,MARKED\n", reading).has_errors);
  // A comment ahead of the program has the name.
  EXPECT_THAT(run_program("SEE M99,HO\n%%5000\nX5.Y5.T1\n" + kTable, {}, reading).texts,
              refused("p.exc:2:1"));
}

/// Two files that were joined: the %% ahead of a subprogram counts for it, not that of another one.
TEST(SubprogramNumbers, TheNearestFormatAheadOfASubprogramIsItsOwn) {
  SubprogramFolder folder;
  folder.with("S.SS5",
              "%%5000\n@A\nX1.Y1.\n$\n%%3000\n@B\nX2.Y2.\n@C\nX3.Y3.\n$\n%%5000\n@D\nX4.Y4.\n");
  const auto diagnostics = [&](const std::string& name) {
    return in_mm("X5.Y5.T1\nX1.Y1.M99," + name + "\n", folder.reading()).diagnostics;
  };
  const std::string refused = "S.SS5:5:1: error[command-format]";
  EXPECT_THAT(diagnostics("A"), Not(Contains(HasSubstr("error["))));
  EXPECT_THAT(diagnostics("B"), Contains(HasSubstr(refused)));
  EXPECT_THAT(diagnostics("C"), Contains(HasSubstr(refused)));
  EXPECT_THAT(diagnostics("D"), Not(Contains(HasSubstr("error["))));
}

/// With a decimal point a number in the same unit has one reading: digits and zeros of [program],
/// which programs in the other language need, do not touch it.
TEST(SubprogramNumbers, ReadsSubprogramsWithPointsUnderOtherDigitsOfTheControl) {
  const auto diagnostics = [](const std::string& line, std::string_view setting) {
    SubprogramFolder folder;
    folder.with("S.SS5", "@OTHER\nX1000\n@HOLES\n" + line + "\n@LAST\nX1000\n");
    ReadOptions reading = folder.reading();
    reading.last_format = *parse_format(setting);
    return in_mm("X5000Y5.T1\nX2000Y1.M99,HOLES\n", reading).diagnostics;
  };
  const std::string refused = "p.exc:3:9: error[format-ambiguous]";
  for (const char* const setting : {"4.2", "lz", "metric,lz,3.3"}) {
    for (const char* const line : {"X1.Y1.",
                                   "X0Y1.T2",
                                   "X1.Y1.(X100)",
                                   "X1.Y1.M97,A12",
                                   "M49,SAX100.Y50.\nX1.Y1.M93",
                                   "M47,FAX1\nX1.Y1.",
                                   "X1.Y1.V2\nX3.Y1.W5"}) {
      EXPECT_THAT(diagnostics(line, setting), Not(Contains(refused))) << line << setting;
    }
    for (const char* const line :
         {"X1.Y1", "/X1.Y1", "X1.Y1.Z10", "X1.Y1.T0T2\nX2.Y1.G2R600F1.\nT0", "M49,MAPT1"}) {
      EXPECT_THAT(diagnostics(line, setting), Contains(refused)) << line << setting;
    }
  }
  EXPECT_THAT(diagnostics("X1.Y1.", "inch"), Contains(refused));
}

TEST(SubprogramNumbers, RefusesSubprogramsThatStateOtherNumbers) {
  SubprogramFolder folder;
  folder.with("S.SS5", "COMMENT\n%%5001\n@HOLES\nX1.Y1.\n");
  const ProgramRun other = in_mm("X5.Y5.T1\nX2.Y1.M99,HOLES\n", folder.reading());
  EXPECT_THAT(other.texts,
              Contains(testing::AllOf(HasSubstr("S.SS5:2:1: error[command-format]"),
                                      HasSubstr("\"%%5001\""))));
  SubprogramFolder indented;
  indented.with("S.SS5", " \t%%5001 \n@HOLES\nX1.Y1.\n");
  EXPECT_THAT(in_mm("X5.Y5.T1\nX2.Y1.M99,HOLES\n", indented.reading()).texts,
              Contains(HasSubstr("S.SS5:1:3: error[command-format]")));
  SubprogramFolder same;
  same.with("S.SS5", "%%5000\n@HOLES\nX1.Y1.\n");
  ReadOptions reading = same.reading();
  reading.last_format = *parse_format("inch,tz,2.4");
  expect_places(hole_places(in_mm("X5.Y5.T1\nX2.Y1.M99,HOLES\n", reading)), {{5, 5}, {3, 2}});
}

}  // namespace
}  // namespace panelcal
