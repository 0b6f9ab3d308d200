// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/turn.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(Turn, IsTheAngleAllAround) {
  constexpr int kDirections = 10'000;
  constexpr double kPromise = 0.0002;
  for (int i = 0; i < kDirections; ++i) {
    const double turn = (i + 0.5) / kDirections;
    const double angle = 2 * std::numbers::pi * turn;
    ASSERT_NEAR(turn_of(7 * std::cos(angle), 7 * std::sin(angle)), turn, kPromise);
  }
}

TEST(Turn, OfTheAxesAndOfNothing) {
  constexpr double kPromise = 0.0002;
  EXPECT_EQ(turn_of(3, 0), 0);
  EXPECT_NEAR(turn_of(0, 3), 0.25, kPromise);
  EXPECT_NEAR(turn_of(-3, 0), 0.5, kPromise);
  EXPECT_NEAR(turn_of(0, -3), 0.75, kPromise);
  EXPECT_EQ(turn_of(0, 0), 0);
}

}  // namespace
}  // namespace panelcal::internal
