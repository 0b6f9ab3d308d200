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
/// The square of how far the mean of three colours of unknown strength is off the middle one, over
/// the variance of their spread: (1/6) / (1/2), strengths being even in their simplex.
constexpr double kOffOfColours2 = 1.0 / 3;
/// Of a sound lens's astigmatism, rms: 16 d a / f^2 of rays that are d waves out of focus and have
/// a waves of astigmatism, up to 1/4 and 1/20, in a picture of up to f = 0.8 cycles/px.
constexpr double kPlainSpread_px2 = 0.1;
constexpr double kMaxSpread_px2 = 1;  // no usable lens's colours: vibration makes more
constexpr double kSureOfAxis = 2;     // times the power of chance: one in six by chance exceeds it

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

/// The part of a power that is neither chance nor anything else as common.
double part_beyond(double power, double common) {
  return power > common ? 1 - common / power : 0;
}

/// By colours: more blur along one direction, on both sides. Chance and the lens's astigmatism have
/// any direction, so that their powers add to that of colours, and turn it.
Eigen::Matrix2d hidden_by_spread(const Eigen::VectorXd& blurs,
                                 const std::vector<char>& use,
                                 double sigma_px) {
  const Eigen::Vector2d axis = wave_of(blurs, use, 2);
  // The variances of the edge along and across differ by 4 s a for a sigma s + a cos 2 phi.
  const double by_wave_px = 4 * sigma_px;
  const double plain_px = kPlainSpread_px2 / by_wave_px;
  const double beyond =
      part_beyond(axis.squaredNorm(), chance_beside(blurs, use, 2) + plain_px * plain_px);
  const double spread_px2 = std::min(kMaxSpread_px2, by_wave_px * axis.norm() * std::sqrt(beyond));
  const double turn = 0.5 * std::atan2(axis.y(), axis.x());
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
  return kOffOfColours2 * spread_px2 *
         (beyond * along * along.transpose() + 0.5 * (1 - beyond) * Eigen::Matrix2d::Identity());
}

}  // namespace

Eigen::Matrix2d hidden_by_blur(const Eigen::VectorXd& blurs,
                               const std::vector<char>& use,
                               double sigma_px) {
  const Eigen::Vector2d side = wave_of(blurs, use, 1);
  const double beyond = part_beyond(side.squaredNorm(), chance_beside(blurs, use, 1));
  return beyond * side * side.transpose() + hidden_by_spread(blurs, use, sigma_px);
}

}  // namespace panelcal::internal
