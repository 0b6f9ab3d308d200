// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_blur.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "vision/round/profile/sector_turns.h"

namespace panelcal::internal {
namespace {

constexpr int kFloorWaves = 6;
/// Colours whose spread blurs an edge have a mean that is off by this part of it.
constexpr double kOffOfColours = 0.35;
constexpr double kPlainSpread_px2 = 0.15;  // a sound lens's astigmatism makes as much
constexpr double kMaxSpread_px2 = 1;       // no usable lens's colours: vibration makes more
constexpr double kSureOfAxis = 3;  // times the power of chance: one in eleven by chance exceeds it

double used_sectors(const std::vector<char>& use) {
  return std::max(1.0, static_cast<double>(std::ranges::count(use, 1)));
}

/// Mean power of a wave by chance, as the next shorter ones have it.
double chance_beside(const Eigen::VectorXd& blurs, const std::vector<char>& use, int n_periods) {
  const auto powers = wave_powers(blurs, use, n_periods + 1, n_periods + kFloorWaves);
  const double power = std::accumulate(powers.begin(), powers.end(), 0.0) / kFloorWaves;
  return 4 * power / used_sectors(use);
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

/// The part of a power that is not chance; 0 if the power is below some times that of chance.
double part_beyond(double power, double by_chance, double sure) {
  return power > sure * by_chance ? 1 - by_chance / power : 0;
}

}  // namespace

Eigen::Matrix2d hidden_by_blur(const Eigen::VectorXd& blurs,
                               const std::vector<char>& use,
                               double sigma_px) {
  const Eigen::Vector2d side = wave_of(blurs, use, 1);
  const Eigen::Vector2d axis = wave_of(blurs, use, 2);
  const double side_beyond = part_beyond(side.squaredNorm(), chance_beside(blurs, use, 1), 1);
  const double axis_beyond =
      part_beyond(axis.squaredNorm(), chance_beside(blurs, use, 2), kSureOfAxis);
  // The variances of the edge along and across differ by 4 s a for a sigma s + a cos 2 phi.
  const double spread_px2 = 4 * sigma_px * axis.norm() * std::sqrt(axis_beyond);
  const double hidden_px2 = kOffOfColours * kOffOfColours *
                            std::max(0.0, std::min(kMaxSpread_px2, spread_px2) - kPlainSpread_px2);
  const double turn = 0.5 * std::atan2(axis.y(), axis.x());
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
  return side_beyond * side * side.transpose() + hidden_px2 * along * along.transpose();
}

}  // namespace panelcal::internal
