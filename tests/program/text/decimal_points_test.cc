// SPDX-License-Identifier: Apache-2.0
#include "program/text/decimal_points.h"

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
}

}  // namespace
}  // namespace panelcal
