// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_arc.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

constexpr int kArcBisections = 40;

/// Information of an arc along its bisector, of the whole rim's.
double arc_information(double arc) {
  const double half = std::numbers::pi * arc;
  const double mean = std::sin(half) / half;
  return 2 * arc * (0.5 + std::sin(2 * half) / (4 * half) - mean * mean);
}

}  // namespace

double equivalent_arc(const Eigen::Matrix3d& normal, double n_sectors) {
  if (!(normal(0, 0) > 0) || !(n_sectors > 0)) return 0;
  const Eigen::Matrix2d shift =
      normal.bottomRightCorner<2, 2>() -
      normal.bottomLeftCorner<2, 1>() * normal.topRightCorner<1, 2>() / normal(0, 0);
  const double middle = 0.5 * shift.trace();
  const double spread = std::hypot(0.5 * (shift(0, 0) - shift(1, 1)), shift(0, 1));
  const double information = (middle - spread) / (0.5 * n_sectors);
  double low = 0;
  double high = 1;
  for (int i = 0; i < kArcBisections; ++i) {
    const double arc = 0.5 * (low + high);
    (arc_information(arc) < information ? low : high) = arc;
  }
  return std::max(high, std::min(1.0, normal(0, 0) / n_sectors));
}

}  // namespace panelcal::internal
