// SPDX-License-Identifier: Apache-2.0
#include "vision/round/rim_blur.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/round/profile/shift_filter.h"

namespace panelcal::internal {
namespace {

constexpr int kFirstFloorWave = 3;  // what is left of one and two periods tells of shifts
constexpr int kFloorWaves = 6;
/// Colours whose spread blurs an edge have a mean that is off by this part of it.
constexpr double kOffOfColours = 0.35;
constexpr double kPlainSpread_px2 = 0.15;  // a sound lens's astigmatism makes as much

double used_sectors(const std::vector<char>& use) {
  return std::max(1.0, static_cast<double>(std::ranges::count(use, 1)));
}

/// Amplitudes of cos and sin of a wave around the rim.
Eigen::Vector2d wave_of(const Eigen::VectorXd& values,
                        const std::vector<char>& use,
                        int n_periods) {
  Eigen::Vector2d wave = Eigen::Vector2d::Zero();
  const auto n = static_cast<double>(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (use[static_cast<std::size_t>(i)] == 0) continue;
    const double phi = 2 * std::numbers::pi * n_periods * static_cast<double>(i) / n;
    wave += values[i] * Eigen::Vector2d(std::cos(phi), std::sin(phi));
  }
  return wave * (2 / used_sectors(use));
}

}  // namespace

Eigen::Matrix2d hidden_by_blur(const Eigen::VectorXd& blurs,
                               const std::vector<char>& use,
                               double sigma_px) {
  double floor = 0;
  for (int k = kFirstFloorWave; k < kFirstFloorWave + kFloorWaves; ++k) {
    floor += wave_power(blurs, use, k) / kFloorWaves;
  }
  const double by_chance = 4 * floor / used_sectors(use);
  const auto beyond = [&](const Eigen::Vector2d& wave) {
    return wave.squaredNorm() > by_chance ? 1 - by_chance / wave.squaredNorm() : 0.0;
  };
  const Eigen::Vector2d side = wave_of(blurs, use, 1);
  const Eigen::Vector2d axis = wave_of(blurs, use, 2);
  // The variances of the edge along and across differ by 4 s a for a sigma s + a cos 2 phi.
  const double spread_px2 = 4 * sigma_px * axis.norm() * std::sqrt(beyond(axis));
  const double hidden_px2 =
      kOffOfColours * kOffOfColours * std::max(0.0, spread_px2 - kPlainSpread_px2);
  const double turn = 0.5 * std::atan2(axis.y(), axis.x());
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
  return beyond(side) * side * side.transpose() + hidden_px2 * along * along.transpose();
}

}  // namespace panelcal::internal
