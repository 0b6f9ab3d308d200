// SPDX-License-Identifier: Apache-2.0
#include "program/text/decimal_points.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(DecimalCoordinates, ArePointsBehindXAndY) {
  EXPECT_TRUE(has_decimal_coordinates("M48\nMETRIC,LZ\n%\nX1.5Y2\nM30\n"));
  EXPECT_TRUE(has_decimal_coordinates("X1000\nY-0.5\n"));
  EXPECT_TRUE(has_decimal_coordinates("X+.5"));
}

TEST(DecimalCoordinates, AreNoneWhereOnlyToolsAndFormatsHavePoints) {
  EXPECT_FALSE(has_decimal_coordinates(""));
  EXPECT_FALSE(has_decimal_coordinates("."));
  EXPECT_FALSE(has_decimal_coordinates("12.5"));
  EXPECT_FALSE(has_decimal_coordinates("METRIC,TZ,000.000\nT1C0.8S55.\n%\nT1\nX1000Y2000\n"));
  EXPECT_FALSE(has_decimal_coordinates(";X1.5 is no coordinate\nX1000\n"));
  EXPECT_FALSE(has_decimal_coordinates("X1000(Y2.5 neither)\r\nX2000\r\n"));
  EXPECT_TRUE(has_decimal_coordinates("X1000(Y2.5 Y3.5)\r\nX2.\r\n"));
  EXPECT_TRUE(has_decimal_coordinates(";X1.5X2.5\nX2000\nY2.5 ;end"));
}

/// Quadratic time would be hours.
TEST(DecimalCoordinates, AreFoundInLinearTimeBehindALongComment) {
  std::string text = ";";
  for (int i = 0; i < 1'000'000; ++i) text += "X.";
  EXPECT_FALSE(has_decimal_coordinates(text));
  EXPECT_TRUE(has_decimal_coordinates(text + "\nX1.5\n"));
}

}  // namespace
}  // namespace panelcal
