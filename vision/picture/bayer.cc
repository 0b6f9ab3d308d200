// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/bayer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace panelcal {
namespace {

tl::unexpected<Diagnostic> bayer_problem(std::string what, std::string expected) {
  return failure({Code::PictureFormat, {}, std::move(what), std::move(expected)});
}

/// Something for each of the four places of a pattern: [row's parity][column's parity].
template <class T>
using Cell = std::array<std::array<T, 2>, 2>;

enum Color { kRed, kGreen, kBlue };

Cell<Color> colors_of(BayerPattern pattern) {
  switch (pattern) {
    case BayerPattern::RG:
      return {{{kRed, kGreen}, {kGreen, kBlue}}};
    case BayerPattern::GR:
      return {{{kGreen, kRed}, {kBlue, kGreen}}};
    case BayerPattern::GB:
      return {{{kGreen, kBlue}, {kRed, kGreen}}};
    case BayerPattern::BG:
      return {{{kBlue, kGreen}, {kGreen, kRed}}};
  }
  return {};
}

/// Gains with a mean of 1 over the four places, so that white stays white.
Cell<float> normalised(const ChannelGains& gains, BayerPattern pattern) {
  if (!gains.validate()) return normalised({}, pattern);
  const std::array<double, 3> of_color = {gains.red, gains.green, gains.blue};
  // Divided by the largest first, since a sum may overflow.
  const double largest = std::max({gains.red, gains.green, gains.blue});
  const double mean =
      (gains.red / largest + 2 * (gains.green / largest) + gains.blue / largest) / 4;
  const Cell<Color> colors = colors_of(pattern);
  Cell<float> cell{};
  for (std::size_t y = 0; y < 2; ++y) {
    for (std::size_t x = 0; x < 2; ++x) {
      cell[y][x] = static_cast<float>(of_color[colors[y][x]] / largest / mean);
    }
  }
  return cell;
}

/// Mirrors about the border pixel itself, which keeps the parity.
int mirrored_once(int i, int n) {
  if (n == 1) return 0;
  if (i < 0) return -i;
  return i < n ? i : 2 * n - 2 - i;
}

/// Adds weight * gain * mosaic of a row; `sums` has a margin of one on either side.
void add_row(
    const Image& mosaic, int y, const Cell<float>& gains, float weight, std::vector<float>& sums) {
  const int row = mirrored_once(y, mosaic.height());
  const auto& gain = gains[static_cast<std::size_t>(row & 1)];
  const float even = weight * gain[0];
  const float odd = weight * gain[1];
  const std::span<const float> from = mosaic.row(row);
  float* to = sums.data() + 1;
  std::size_t x = 0;
  for (; x + 1 < from.size(); x += 2) {
    to[x] += even * from[x];
    to[x + 1] += odd * from[x + 1];
  }
  if (x < from.size()) to[x] += even * from[x];
}

}  // namespace

Expected<void> ChannelGains::validate() const {
  const std::array<std::pair<std::string_view, double>, 3> all = {
      {{"red", red}, {"green", green}, {"blue", blue}}};
  for (const auto& [color, gain] : all) {
    if (std::isfinite(gain) && gain >= 0) continue;
    return bayer_problem(fmt::format("gain of {} {}", color, gain), "0 or more");
  }
  if (red > 0 || green > 0 || blue > 0) return {};
  return bayer_problem("all gains are 0", "one above 0");
}

std::optional<BayerPattern> bayer_pattern_from_name(std::string_view name) {
  if (name == "RG") return BayerPattern::RG;
  if (name == "GR") return BayerPattern::GR;
  if (name == "GB") return BayerPattern::GB;
  if (name == "BG") return BayerPattern::BG;
  return std::nullopt;
}

Image from_bayer(const Image& mosaic, BayerPattern pattern, const ChannelGains& gains) {
  if (mosaic.empty()) return mosaic;
  const Cell<float> cell = normalised(gains, pattern);
  const int width = mosaic.width();
  const auto full_scale = static_cast<float>(mosaic.full_scale());
  // Gains do not sum up to exactly 1; clipped levels shall be full scale all the same.
  const float almost_full = full_scale * (1 - 1e-6F);
  Image image(width, mosaic.height(), mosaic.full_scale());
  std::vector<float> sums(static_cast<std::size_t>(width) + 2);
  for (int y = 0; y < mosaic.height(); ++y) {
    std::fill(sums.begin(), sums.end(), 0.0F);
    add_row(mosaic, y - 1, cell, 0.25F, sums);
    add_row(mosaic, y, cell, 0.5F, sums);
    add_row(mosaic, y + 1, cell, 0.25F, sums);
    sums.front() = sums[static_cast<std::size_t>(1 + mirrored_once(-1, width))];
    sums.back() = sums[static_cast<std::size_t>(1 + mirrored_once(width, width))];
    const float* at = sums.data();
    for (float& level : image.row(y)) {
      const float grey = 0.25F * (at[0] + at[2]) + 0.5F * at[1];
      level = grey >= almost_full ? full_scale : grey;
      ++at;
    }
  }
  return image;
}

ChannelGains estimated_gains(const Image& mosaic, BayerPattern pattern) {
  const Cell<Color> colors = colors_of(pattern);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  int n = 0;
  for (int y = 0; y + 1 < mosaic.height(); y += 2) {
    for (int x = 0; x + 1 < mosaic.width(); x += 2) {
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      for (std::size_t j = 0; j < 2; ++j) {
        for (std::size_t i = 0; i < 2; ++i) {
          color[colors[j][i]] +=
              static_cast<double>(mosaic.at(x + static_cast<int>(i), y + static_cast<int>(j)));
        }
      }
      color[kGreen] *= 0.5;
      sum += color;
      squares += color * color.transpose();
      ++n;
    }
  }
  if (n == 0) return {};
  const Eigen::Vector3d mean = sum / n;
  const Eigen::Matrix3d covariance = squares / n - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  // Noise alone has a ratio of 2, since green is the mean of two.
  constexpr double kLeastRatio = 8;
  const Eigen::Vector3d strength = solver.eigenvalues();
  const double rounding = 1e-9 * mosaic.full_scale() * mosaic.full_scale();
  if (strength[2] <= kLeastRatio * std::max(strength[0], 0.0) + rounding) return {};
  Eigen::Vector3d direction = solver.eigenvectors().col(2);
  if (direction.sum() < 0) direction = -direction;
  direction = direction.cwiseMax(0) / direction.maxCoeff();
  return {direction[kRed], direction[kGreen], direction[kBlue]};
}

}  // namespace panelcal
