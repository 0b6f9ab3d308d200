// SPDX-License-Identifier: Apache-2.0
#include "program/walk/dialect.h"

#include <set>
#include <string>

#include "program/excellon/text/header.h"
#include "program/sieb_meyer/text/file_layout.h"
#include "program/walk/walk.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(Dialects, HaveAnIdEachAndTheLastTakesAnyText) {
  std::set<Dialect> ids;
  for (const ProgramDialect* dialect : dialects()) ids.insert(dialect->id());
  EXPECT_EQ(ids.size(), dialects().size());
  EXPECT_TRUE(dialects().back()->begins(""));
}

TEST(Dialects, GiveAProgramTheHeadOfItsLanguage) {
  DiagnosticLog log;
  const Program excellon = load_program({"p", "M48\nINCH,LZ\nT1C.04\n%\nM30\n"}, log);
  ASSERT_EQ(excellon.dialect, Dialect::Excellon);
  EXPECT_TRUE(excellon::header_of(excellon).stated.states_unit());
  EXPECT_EQ(excellon.tools().size(), 1U);

  const Program sieb_meyer = load_program({"p", "%%5000\nX1000Y1000T1\n$\nT1D1.0\n$\n"}, log);
  ASSERT_EQ(sieb_meyer.dialect, Dialect::SiebMeyer);
  EXPECT_EQ(sieb_meyer::layout_of(sieb_meyer).head_line, 1);
  EXPECT_NE(sieb_meyer.number_summary(), excellon.number_summary());
}

/// Digits of the output must not depend on the case of letters or on block numbers.
TEST(Dialects, KnowDecimalCoordinatesInAnySpelling) {
  const auto has_points = [](const char* body) {
    DiagnosticLog log;
    return program_info(load_program({"p", std::string("M48\nMETRIC,TZ,000.00\n%\n") + body}, log),
                        {})
        .has_decimal_coordinates;
  };
  EXPECT_TRUE(has_points("X1.255Y1.\nM30\n"));
  EXPECT_TRUE(has_points("x1.255y1.\nm30\n"));
  EXPECT_TRUE(has_points("(hole) X1.255Y1.\nM30\n"));
  EXPECT_FALSE(has_points("x125y100 ;x1.25\nm30\n"));
}

TEST(Dialects, LeaveTheHeadEmptyOfAProgramThatIsNotRead) {
  const Program program;
  EXPECT_TRUE(program.tools().empty());
  EXPECT_EQ(program.axis_version(), 1);
}

}  // namespace
}  // namespace panelcal
