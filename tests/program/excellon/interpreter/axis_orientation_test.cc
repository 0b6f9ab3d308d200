// SPDX-License-Identifier: Apache-2.0
#include "program/model/placement.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

double determinant(const Eigen::Matrix2d& m) {
  return m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
}

TEST(AxisOrientation, CarriesTheAxesOfEachVersion) {
  const Eigen::Vector2d right(1, 0);
  const Eigen::Vector2d up(0, 1);
  struct Axes {
    int version;
    Eigen::Vector2d x;
    Eigen::Vector2d y;
  };
  const Axes all[] = {{1, right, up},
                      {2, up, right},
                      {3, up, -right},
                      {4, -right, up},
                      {5, -up, -right},
                      {6, -right, -up},
                      {7, right, -up},
                      {8, -up, right}};
  for (const Axes& axes : all) {
    const Eigen::Matrix2d orientation = axis_orientation(axes.version);
    EXPECT_EQ(Eigen::Vector2d(orientation * right), axes.x) << axes.version;
    EXPECT_EQ(Eigen::Vector2d(orientation * up), axes.y) << axes.version;
  }
}

/// SIEB & MEYER manual, G2 and G3, table "Routing direction"; G41 and G42 have the same table.
TEST(AxisOrientation, ManualRoutingDirection) {
  for (const int version : {1, 3, 6, 8}) {
    EXPECT_EQ(determinant(axis_orientation(version)), 1) << version;
  }
  for (const int version : {2, 4, 5, 7}) {
    EXPECT_EQ(determinant(axis_orientation(version)), -1) << version;
  }
}

TEST(AxisOrientation, TheTransposeLeadsBack) {
  for (int version = 1; version <= 8; ++version) {
    const Eigen::Matrix2d orientation = axis_orientation(version);
    EXPECT_EQ(Eigen::Matrix2d(orientation * orientation.transpose()),
              Eigen::Matrix2d(Eigen::Matrix2d::Identity()))
        << version;
  }
}

}  // namespace
}  // namespace panelcal
