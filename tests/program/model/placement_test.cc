// SPDX-License-Identifier: Apache-2.0
#include "program/model/placement.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

Eigen::Vector2d oriented(const CopyRun& run) {
  return copy_orientation(run) * Eigen::Vector2d(3, 5);
}

TEST(CopyOrientation, ManualMirrorImageAndSwapAxis) {
  EXPECT_EQ(oriented({}), Eigen::Vector2d(3, 5));
  EXPECT_EQ(oriented({.mirror_x = true}), Eigen::Vector2d(-3, 5));
  EXPECT_EQ(oriented({.mirror_y = true}), Eigen::Vector2d(3, -5));
  EXPECT_EQ(oriented({.mirror_x = true, .mirror_y = true}), Eigen::Vector2d(-3, -5));
  EXPECT_EQ(oriented({.swap_axes = true}), Eigen::Vector2d(5, 3));
}

TEST(CopyOrientation, MirrorsActBeforeSwap) {
  EXPECT_EQ(oriented({.mirror_x = true, .swap_axes = true}), Eigen::Vector2d(5, -3));
  EXPECT_EQ(oriented({.mirror_y = true, .swap_axes = true}), Eigen::Vector2d(-5, 3));
  EXPECT_EQ(oriented({.mirror_x = true, .mirror_y = true, .swap_axes = true}),
            Eigen::Vector2d(-5, -3));
}

}  // namespace
}  // namespace panelcal
