// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/strip.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr double kStripBlur_px = 0.8;

double step_at(double at_px, double x_px) {
  return 0.5 * std::erfc((at_px - x_px) / (kStripBlur_px * std::numbers::sqrt2));
}

/// Rings from 8 px outside of the circle to 8 px inside; the second step lies `other_px` inwards.
RimStrip strip_of(double height, double other, double other_px, Eigen::ArrayXd& medians) {
  RimStrip strip;
  strip.first_px = -8;
  medians.resize(17);
  for (Eigen::Index j = 0; j < medians.size(); ++j) {
    const double x = -8 + static_cast<double>(j);
    medians[j] = 40 + height * step_at(0, x) + other * step_at(other_px, x);
  }
  strip.mean = medians.cast<float>().replicate(1, 5);
  strip.mass = Eigen::ArrayXd::Ones(17);
  return strip;
}

TEST(RimStrip, KeepsTheWeakerEdgeThatLiesAtTheCircle) {
  Eigen::ArrayXd medians;
  RimStrip strip = strip_of(40, 100, -4, medians);
  keep_one_edge(2, 1, medians, strip);
  EXPECT_GE(strip.first_px, -3);
  EXPECT_LE(strip.first_px, -1);
  EXPECT_EQ(strip.at_px(strip.n_rings() - 1), 8);
  EXPECT_EQ(strip.n_rings(), medians.size());
  EXPECT_EQ(strip.mass.size(), medians.size());
  EXPECT_FLOAT_EQ(strip.mean(0, 2), static_cast<float>(medians[0]));
  EXPECT_NEAR(medians[medians.size() - 1], 180, 1);

  strip = strip_of(40, 100, 4, medians);
  keep_one_edge(2, 1, medians, strip);
  EXPECT_EQ(strip.first_px, -8);
  EXPECT_GE(strip.at_px(strip.n_rings() - 1), 1);
  EXPECT_LE(strip.at_px(strip.n_rings() - 1), 3);
}

TEST(RimStrip, KeepsAllAroundASingleEdge) {
  for (const double sign : {1.0, -1.0}) {
    Eigen::ArrayXd medians;
    RimStrip strip = strip_of(sign * 40, 0, 0, medians);
    keep_one_edge(2, sign, medians, strip);
    EXPECT_EQ(strip.n_rings(), 17);
    EXPECT_EQ(strip.first_px, -8);
  }
}

}  // namespace
}  // namespace panelcal::internal
