// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/number_census.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

bool has_bare(const std::string& program) {
  return find_bare_number(program, {}).has_value();
}

TEST(NumberCensus, ALoneZeroIsTheSameInEveryFormat) {
  EXPECT_FALSE(has_bare("X0Y1.5\nX1.5Y0\nX0\nY0\nX00Y-0\nXY\nM30\n"));
  EXPECT_FALSE(has_bare("X1.5Y0"));
  for (const char* bare : {"X01Y1.5\n", "X1.5Y10\n", "X0Y5", "X1.5Y05", "X-1Y0\n"}) {
    EXPECT_TRUE(has_bare(bare)) << bare;
  }
}

/// Many lines are looked at together, at any place of which a number may stand.
TEST(NumberCensus, FindsABareNumberAmongManyLines) {
  for (const char* lines : {"X0Y1.25\n", "X1.25Y0\r\n", "Y0\n", "X10.5\n"}) {
    for (int n_before = 0; n_before < 400; n_before += 7) {
      std::string program;
      for (int i = 0; i < n_before; ++i) program += lines;
      std::string behind;
      for (int i = 0; i < 300; ++i) behind += lines;
      EXPECT_FALSE(has_bare(program + behind)) << lines << n_before;
      for (const char* bare : {"X05\n", "Y0X3\n", "X00Y1\n"}) {
        EXPECT_TRUE(has_bare(program + bare + behind)) << lines << n_before << bare;
        EXPECT_TRUE(has_bare(program + bare)) << lines << n_before << bare;
      }
    }
  }
}

/// A point too many does not stand for one that is missing behind a zero.
TEST(NumberCensus, CountsAZeroWithAPointOnce) {
  EXPECT_TRUE(has_bare("X0.Y15\n"));
  EXPECT_TRUE(has_bare("X0.5Y15\n"));
  EXPECT_FALSE(has_bare("X0.Y15.\n"));
}

/// Lines that are passed over together count as well.
TEST(NumberCensus, NamesTheFirstBareNumberWithItsPlace) {
  std::string program;
  for (int i = 0; i < 500; ++i) program += "X1.25Y0\r\n";
  const auto found = find_bare_number(program + "T1C0.8\nY3.5X-025\nX1\n", {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->text, "X-025");
  EXPECT_EQ(found->line, 502);
  EXPECT_EQ(found->column, 5);
}

/// Each number of a setting is looked at; the tool of PCKPARAM and the index of CP are no lengths.
TEST(NumberCensus, FindsABareNumberBesideAPointedOne) {
  for (const char* bare : {"ZC,X1.0Y2000\n",
                           "CAN_TEXT_OFF,1.0,2000\n",
                           "PCKPARAM,1,.5,20\n",
                           "CP,1,05\n",
                           "G34,1,2,3,4,05\n",
                           "$uvis,focus,x1.0y2\n"}) {
    EXPECT_TRUE(has_bare(bare)) << bare;
    NumberCensus census;
    take_census(bare, {}, census);
    EXPECT_TRUE(census.has_other_bare_lengths) << bare;
  }
  for (const char* pointed : {"ZC,X1.0Y2.0\n",
                              "CAN_TEXT_OFF,1.0,0\n",
                              "PCKPARAM,1,.5,2.0\n",
                              "CP,1,.5\n",
                              "G34,1,2,3,4,.5\n"}) {
    EXPECT_FALSE(has_bare(pointed)) << pointed;
  }
}

TEST(NumberCensus, ZerosDoNotHideHowFarAJobExtends) {
  NumberCensus census;
  take_census("X0Y1.5\nX10.5Y0\nM30\nX5\n", {}, census);
  const NumberFormat metric{.unit = LengthUnit::Millimeter};
  EXPECT_EQ(census.x.in(metric).least_mm, 0);
  EXPECT_DOUBLE_EQ(census.x.in(metric).most_mm, 10.5);
  EXPECT_EQ(census.first.text, "X0");
  EXPECT_EQ(census.first.line, 1);
  EXPECT_FALSE(census.has_other_lengths);
}

}  // namespace
}  // namespace panelcal::excellon
