// SPDX-License-Identifier: Apache-2.0
#include "calib/base/append_format.h"

#include <array>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(AppendFormat, KeepsTheTextBefore) {
  std::string out = "T1";
  append_format(out, "X{:.3f}{}", 1.5, std::string("Y2"));
  append_format(out, "{:0{}}", 7, 4);
  EXPECT_EQ(out, "T1X1.500Y20007");
}

TEST(AppendFormat, JoinsNumbersInTheirShortestForm) {
  const std::array<double, 3> numbers = {0.1, -0.0, 1e22};
  EXPECT_EQ(joined(numbers, ", "), "0.1, -0, 1e+22");
  EXPECT_EQ(joined({}, ", "), "");
}

}  // namespace
}  // namespace panelcal::internal
