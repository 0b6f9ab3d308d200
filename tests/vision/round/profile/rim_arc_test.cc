// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_arc.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr int kArcSectors = 400;
constexpr double kOfASector = 2.0 / kArcSectors;

/// Normal equations of the sectors that are seen, turned by something.
template <class Predicate>
Eigen::Matrix3d normal_of(Predicate is_seen) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kArcSectors; ++i) {
    if (!is_seen(i)) continue;
    const double phi = 0.7 + 2 * std::numbers::pi * i / kArcSectors;
    const Eigen::Vector3d row(1, std::cos(phi), std::sin(phi));
    normal += row * row.transpose();
  }
  return normal;
}

TEST(RimArc, AnArcIsItsOwnEquivalent) {
  for (const int n_seen : {80, 160, 200, 280, 360, 400}) {
    const Eigen::Matrix3d normal = normal_of([&](int i) { return i < n_seen; });
    EXPECT_NEAR(
        equivalent_arc(normal, kArcSectors), static_cast<double>(n_seen) / kArcSectors, kOfASector);
  }
}

/// 2 a (1/2 + sin(2 pi a) / (4 pi a) - (sin(pi a) / (pi a))^2) is 1/2 at a = 0.7714, 0.6 at 0.8177:
/// bisected by hand.
TEST(RimArc, PartsThatAreSpreadTellAsMuchAsALongerArc) {
  const Eigen::Matrix3d half = normal_of([](int i) { return i / 10 % 2 == 0; });
  EXPECT_NEAR(equivalent_arc(half, kArcSectors), 0.7714, 0.01);
  const Eigen::Matrix3d more = normal_of([](int i) { return i % 50 < 30; });
  EXPECT_NEAR(equivalent_arc(more, kArcSectors), 0.8177, 0.01);
}

TEST(RimArc, TwoArcsOppositeTellLessThanFour) {
  const auto arcs = [](int n_arcs) {
    return equivalent_arc(
        normal_of([&](int i) { return i % (kArcSectors / n_arcs) < kArcSectors / n_arcs / 2; }),
        kArcSectors);
  };
  EXPECT_NEAR(arcs(1), 0.5, kOfASector);
  EXPECT_GT(arcs(2), arcs(1) + 0.05);
  EXPECT_GT(arcs(4), arcs(2) + 0.05);
}

TEST(RimArc, NothingSeenIsNoArc) {
  EXPECT_EQ(equivalent_arc(Eigen::Matrix3d::Zero(), kArcSectors), 0);
}

}  // namespace
}  // namespace panelcal::internal
