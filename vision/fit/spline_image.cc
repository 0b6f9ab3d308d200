// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/spline_image.h"

namespace panelcal::internal {
namespace {

/// The pole of the cubic B-spline's inverse filter, sqrt(3) - 2.
constexpr double kPole = -0.2679491924311227;
/// Its powers are below 1e-16 from here on.
constexpr int kPoleReach = 28;

/// Filters n numbers that lie `stride` apart.
void filter_line(double* line, int n, std::size_t stride) {
  if (n < 2) return;
  const auto at = [&](int i) -> double& { return line[static_cast<std::size_t>(i) * stride]; };
  // The line mirrored at its first number goes on for ever: the sum of its tail.
  double sum = at(0);
  double power = kPole;
  const int period = 2 * n - 2;
  for (int k = 1; k < kPoleReach; ++k, power *= kPole) {
    const int i = k % period;
    sum += power * at(i < n ? i : period - i);
  }
  at(0) = sum;
  for (int i = 1; i < n; ++i) at(i) += kPole * at(i - 1);
  at(n - 1) = kPole / (kPole * kPole - 1) * (at(n - 1) + kPole * at(n - 2));
  for (int i = n - 2; i >= 0; --i) at(i) = kPole * (at(i + 1) - at(i));
  for (int i = 0; i < n; ++i) at(i) *= 6;
}

}  // namespace

Raster spline_coefficients(const Raster& values) {
  Raster result = values;
  for (int y = 0; y < result.height; ++y) filter_line(&result.at(0, y), result.width, 1);
  for (int x = 0; x < result.width; ++x) {
    filter_line(&result.at(x, 0), result.height, static_cast<std::size_t>(result.width));
  }
  return result;
}

}  // namespace panelcal::internal
