// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace panelcal::test {

/// Checks a property of random programs whose outcome may also be a refusal, which compares
/// nothing. The property gives whether it has compared this program. At least the share `min_share`
/// of all programs has to be compared, or the test would pass where everything is refused.
template <class Property>
void check_compared(const std::string& description, double min_share, Property property) {
  int n_drawn = 0;
  int n_compared = 0;
  const bool holds = rc::check(description, [&] {
    const bool is_compared = property();
    ++n_drawn;
    if (is_compared) ++n_compared;
  });
  EXPECT_TRUE(holds) << description;
  EXPECT_GT(n_compared, 0) << description;
  EXPECT_GE(n_compared, min_share * n_drawn) << description << ": of " << n_drawn << " programs";
}

}  // namespace panelcal::test
