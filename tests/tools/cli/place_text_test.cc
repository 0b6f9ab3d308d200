// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/place_text.h"

#include <array>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(PlaceText, WritesNumbersAsPeopleReadThem) {
  EXPECT_EQ(report::grouped(-1234567), "-1,234,567");
  EXPECT_EQ(report::grouped(999), "999");
  EXPECT_EQ(report::fixed(-0.0004, 3), "0.000");
  EXPECT_EQ(report::fixed_signed(0.25, 2), "+0.25");
  EXPECT_EQ(report::fixed_signed(-0.25, 2), "-0.25");
}

TEST(PlaceText, WritesPlacesAndPaths) {
  EXPECT_EQ(report::point_text({15, 89.0264}), "(15.000, 89.026)");
  EXPECT_EQ(report::path_text(std::array{0, 1}), "[0,1]");
  EXPECT_EQ(report::path_text({}), "");
}

}  // namespace
}  // namespace panelcal
