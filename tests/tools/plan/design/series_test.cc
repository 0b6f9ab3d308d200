// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/series.h"

#include <gtest/gtest.h>

namespace panelcal::plan {
namespace {

TEST(ErrorTrialCount, TakesNoMoreWorkOfManyTargetsThanOfSixteen) {
  for (const std::size_t n : {1U, 4U, 16U}) EXPECT_EQ(error_trials(n), kErrorTrials) << n;
  for (std::size_t n = 17; n <= kMostTriedTargets; ++n) {
    const int n_trials = error_trials(n);
    EXPECT_LE(n_trials * static_cast<double>(n * n), kErrorTrials * 16.0 * 16.0) << n;
    // Of 20 cases a share of a half is known to 11 %.
    EXPECT_GE(n_trials, 20) << n;
  }
  for (const std::size_t n : {kMostTriedTargets + 1, std::size_t{1000}}) {
    EXPECT_EQ(error_trials(n), 0) << n;
  }
}

}  // namespace
}  // namespace panelcal::plan
