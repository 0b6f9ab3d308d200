// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/regression.h"

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(Regression, HasTheGainOfALine) {
  Regression sums;
  for (const double m : {0.0, 1.0, 2.0, 5.0}) sums.add(m, 7 - 3 * m);
  EXPECT_NEAR(sums.gain(), -3, 1e-12);
  EXPECT_EQ(sums.correlation(0), 0) << "the opposite of the model is no likeness";
}

TEST(Regression, CorrelationIsThatWithoutTheNoise) {
  constexpr double kNoise = 2;
  Random random(5);
  Regression sums;
  for (int i = 0; i < 20'000; ++i) {
    const double m = i % 2 == 0 ? 0 : 3;
    sums.add(m, m + kNoise * random.normal());
  }
  // Variances 2.25 of the model and 4 of the noise.
  EXPECT_NEAR(sums.correlation(0), std::sqrt(2.25 / 6.25), 0.02);
  EXPECT_NEAR(sums.correlation(kNoise * kNoise), 1, 0.03);
}

TEST(Regression, NoiseIsThreeQuartersOfWhatIsSeenAtMost) {
  Regression sums;
  for (const double m : {0.0, 1.0}) sums.add(m, m);
  sums.add(0.5, 3.5);
  const double plain = sums.correlation(0);
  EXPECT_NEAR(sums.correlation(1e6), 2 * plain, 1e-12);
}

TEST(Regression, FlatModelsAndPicturesAreAlikeInNothing) {
  Regression sums;
  EXPECT_EQ(sums.correlation(0), 0);
  for (const double v : {1.0, 4.0}) sums.add(2, v);
  EXPECT_EQ(sums.correlation(0), 0);
}

}  // namespace
}  // namespace panelcal::internal
