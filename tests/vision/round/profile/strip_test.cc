// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/strip.h"

#include <algorithm>
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

constexpr double kAbout_px = 0.6;  // rings are 1 px apart

TEST(RimStrip, KeepsTheWeakerEdgeThatLiesAtTheCircle) {
  for (const double side : {-1.0, 1.0}) {
    Eigen::ArrayXd medians;
    RimStrip strip = strip_of(40, 100, 4 * side, medians);
    keep_nearest_edge(0, 1.5, 1, medians, strip);
    ASSERT_EQ(strip.others_px.size(), 1U);
    EXPECT_NEAR(strip.others_px[0], 4 * side, kAbout_px);
    EXPECT_EQ(strip.n_rings(), medians.size());
    EXPECT_EQ(strip.mass.size(), medians.size());
    EXPECT_FLOAT_EQ(strip.mean(0, 2), static_cast<float>(medians[0]));
    // All of the other edge, as far as it rises.
    EXPECT_LE(strip.first_px, side < 0 ? -6 : -8);
    EXPECT_GE(strip.at_px(strip.n_rings() - 1), side < 0 ? 8 : 6);
  }
}

TEST(RimStrip, KeepsTheEdgeThatIsExpected) {
  Eigen::ArrayXd medians;
  RimStrip strip = strip_of(40, 100, -4, medians);
  keep_nearest_edge(-4, 1.5, 1, medians, strip);
  ASSERT_EQ(strip.others_px.size(), 1U);
  EXPECT_NEAR(strip.others_px[0], 0, kAbout_px);
}

TEST(RimStrip, ASlopeThatGoesOnIsNoEdge) {
  Eigen::ArrayXd medians;
  RimStrip strip = strip_of(40, 0, 0, medians);
  for (Eigen::Index j = 0; j < medians.size(); ++j) {
    const double inside = std::max(0.0, strip.at_px(j) - 2);
    medians[j] += inside * inside;
  }
  keep_nearest_edge(0, 1.5, 1, medians, strip);
  EXPECT_TRUE(strip.others_px.empty());
  EXPECT_LT(strip.at_px(strip.n_rings() - 1), 8);
}

TEST(RimStrip, KeepsAllAroundASingleEdge) {
  for (const double sign : {1.0, -1.0}) {
    Eigen::ArrayXd medians;
    RimStrip strip = strip_of(sign * 40, 0, 0, medians);
    keep_nearest_edge(0, 1.5, sign, medians, strip);
    EXPECT_TRUE(strip.others_px.empty());
    EXPECT_EQ(strip.n_rings(), 17);
    EXPECT_EQ(strip.first_px, -8);
  }
}

/// A camera that sharpens draws a dark ring and a bright one along the edge: its level rises and
/// falls there, and rises nowhere else.
TEST(RimStrip, TheBandsOfASharpenedEdgeAreNoEdges) {
  Eigen::ArrayXd medians;
  RimStrip strip = strip_of(40, 0, 0, medians);
  for (Eigen::Index j = 0; j < medians.size(); ++j) {
    const double x = strip.at_px(j);
    medians[j] += 8 * x * std::exp(-0.25 * x * x);
  }
  keep_nearest_edge(0, 1.5, 1, medians, strip);
  EXPECT_TRUE(strip.others_px.empty());
  EXPECT_EQ(strip.n_rings(), 17);
}

}  // namespace
}  // namespace panelcal::internal
