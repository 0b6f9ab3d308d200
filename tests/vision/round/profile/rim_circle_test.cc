// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_circle.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr Eigen::Index kCircleSectors = 120;
constexpr double kSectorNoise_px = 0.02;

/// A circle shifted by (0.3, -0.2) and grown by 0.1 px.
Eigen::VectorXd shifted_circle(Random& random) {
  Eigen::VectorXd d(kCircleSectors);
  for (Eigen::Index i = 0; i < kCircleSectors; ++i) {
    const double phi = 2 * std::numbers::pi * static_cast<double>(i) / kCircleSectors;
    d[i] = 0.1 + 0.3 * std::cos(phi) - 0.2 * std::sin(phi) + kSectorNoise_px * random.normal();
  }
  return d;
}

std::vector<char> all_usable() {
  return std::vector<char>(static_cast<std::size_t>(kCircleSectors), 1);
}

TEST(RimCircle, FindsAShiftedCircle) {
  Random random(1);
  const RimCircle circle =
      fit_rim_circle(shifted_circle(random), all_usable(), 1, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.shift_px.x(), 0.3, 0.01);
  EXPECT_NEAR(circle.shift_px.y(), -0.2, 0.01);
  EXPECT_NEAR(circle.grown_px, 0.1, 0.01);
  EXPECT_GT(circle.seen, 0.95);
  EXPECT_NEAR(circle.unit_cov(0, 0), 2.0 / kCircleSectors, 0.2 / kCircleSectors);
}

TEST(RimCircle, WithstandsADisplacedQuarter) {
  Random random(2);
  Eigen::VectorXd d = shifted_circle(random);
  for (Eigen::Index i = 10; i < 40; ++i) d[i] -= 0.6;
  const RimCircle circle = fit_rim_circle(d, all_usable(), 1, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.shift_px.x(), 0.3, 0.015);
  EXPECT_NEAR(circle.shift_px.y(), -0.2, 0.015);
  EXPECT_NEAR(circle.seen, 0.75, 0.03);
  EXPECT_NEAR(circle.displaced, 0.25, 0.03);
}

TEST(RimCircle, AWobblyRimIsTakenWhole) {
  // Three quarters of an egg lie better on a circle that is shifted than all of it on its own.
  Random random(6);
  Eigen::VectorXd d = shifted_circle(random);
  for (Eigen::Index i = 0; i < kCircleSectors; ++i) {
    const double phi = 2 * std::numbers::pi * static_cast<double>(i) / kCircleSectors;
    d[i] += 0.8 * std::cos(2 * phi) + 0.3 * std::sin(3 * phi);
  }
  const RimCircle arc = fit_rim_circle(d, all_usable(), 1, 0.6, kSectorNoise_px);
  EXPECT_GT((arc.shift_px - Eigen::Vector2d(0.3, -0.2)).norm(), 0.3);
  const RimCircle whole = fit_rim_circle(d, all_usable(), 1, 0.6, kSectorNoise_px, 1.5);
  EXPECT_NEAR(whole.shift_px.x(), 0.3, 0.02);
  EXPECT_NEAR(whole.shift_px.y(), -0.2, 0.02);
  EXPECT_GT(whole.seen, 0.95);
  EXPECT_GT(whole.doubt_px.norm(), 0.3);
}

TEST(RimCircle, ADisplacedQuarterIsNoWobble) {
  Random random(7);
  Eigen::VectorXd d = shifted_circle(random);
  for (Eigen::Index i = 10; i < 40; ++i) d[i] -= 0.6;
  const RimCircle circle = fit_rim_circle(d, all_usable(), 1, 0.7, kSectorNoise_px, 1.5);
  EXPECT_NEAR(circle.shift_px.x(), 0.3, 0.015);
  EXPECT_NEAR(circle.shift_px.y(), -0.2, 0.015);
  EXPECT_EQ(circle.doubt_px.norm(), 0);
}

TEST(RimCircle, SectorsWithoutAnEdgeAreNotDisplaced) {
  Random random(3);
  Eigen::VectorXd d = shifted_circle(random);
  std::vector<char> usable = all_usable();
  for (Eigen::Index i = 60; i < 75; ++i) {
    d[i] = 5;
    usable[static_cast<std::size_t>(i)] = 0;
  }
  const RimCircle circle = fit_rim_circle(d, usable, 3, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.shift_px.x(), 0.3, 0.015);
  EXPECT_LT(circle.displaced, 0.05);
  EXPECT_LT(circle.used(), 0.88);
}

/// Spots on 42 % of the rim, and an arc of 5 % that is displaced.
TEST(RimCircle, IsFittedToPartsThatAreSpread) {
  Random random(8);
  Eigen::VectorXd d = shifted_circle(random);
  std::vector<char> usable = all_usable();
  for (Eigen::Index i = 0; i < kCircleSectors; ++i) {
    if (i % 12 >= 7) usable[static_cast<std::size_t>(i)] = 0;
    if (i >= 24 && i < 31) d[i] -= 0.6;
  }
  const RimCircle circle = fit_rim_circle(d, usable, 1, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.shift_px.x(), 0.3, 0.015);
  EXPECT_NEAR(circle.shift_px.y(), -0.2, 0.015);
  EXPECT_NEAR(circle.seen, 0.525, 0.03);
  EXPECT_GT(circle.arc, 0.7);
}

TEST(RimCircle, ASingleArcIsNoMoreThanItsLength) {
  Random random(9);
  std::vector<char> usable = all_usable();
  for (std::size_t i = 0; i < 48; ++i) usable[i] = 0;
  const RimCircle circle = fit_rim_circle(shifted_circle(random), usable, 1, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.seen, 0.6, 0.02);
  EXPECT_NEAR(circle.arc, 0.6, 0.02);
}

TEST(RimCircle, TellsAnOval) {
  Random random(4);
  Eigen::VectorXd d = shifted_circle(random);
  for (Eigen::Index i = 0; i < kCircleSectors; ++i) {
    d[i] += 0.15 * std::cos(4 * std::numbers::pi * static_cast<double>(i) / kCircleSectors);
  }
  const RimCircle circle = fit_rim_circle(d, all_usable(), 1, 0.7, kSectorNoise_px);
  EXPECT_NEAR(circle.oval_px.x(), 0.15, 0.03);
  EXPECT_NEAR(circle.oval_px.y(), 0, 0.02);
}

}  // namespace
}  // namespace panelcal::internal
