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

int mirrored_periodically(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * n - 2;
  i = std::abs(i) % period;
  return i < n ? i : period - i;
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

Raster blurred(const Raster& in, double sigma_px) {
  if (!(sigma_px > 0) || in.values.empty()) return in;
  const int reach = std::max(1, static_cast<int>(std::ceil(4 * sigma_px)));
  std::vector<double> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    const double value = std::exp(-0.5 * i * i / (sigma_px * sigma_px));
    kernel[static_cast<std::size_t>(i + reach)] = value;
    sum += value;
  }
  for (double& v : kernel) v /= sum;
  Raster rows(in.width, in.height);
  Raster out(in.width, in.height);
  for (int k = -reach; k <= reach; ++k) {
    const double weight = kernel[static_cast<std::size_t>(k + reach)];
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) {
        rows.at(x, y) += weight * in.at(mirrored_periodically(x + k, in.width), y);
      }
    }
  }
  for (int k = -reach; k <= reach; ++k) {
    const double weight = kernel[static_cast<std::size_t>(k + reach)];
    for (int y = 0; y < in.height; ++y) {
      const int from = mirrored_periodically(y + k, in.height);
      for (int x = 0; x < in.width; ++x) out.at(x, y) += weight * rows.at(x, from);
    }
  }
  return out;
}

Raster averaged(const Raster& in, int factor) {
  if (factor <= 1) return in;
  Raster out(in.width / factor, in.height / factor);
  const double weight = 1.0 / (factor * factor);
  for (int y = 0; y < out.height * factor; ++y) {
    for (int x = 0; x < out.width; ++x) {
      double sum = 0;
      for (int i = 0; i < factor; ++i) sum += in.at(x * factor + i, y);
      out.at(x, y / factor) += weight * sum;
    }
  }
  return out;
}

}  // namespace panelcal::internal
