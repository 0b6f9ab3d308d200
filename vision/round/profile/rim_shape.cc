// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_shape.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "vision/round/profile/sector_turns.h"

namespace panelcal::internal {
namespace {

constexpr int kSectorsPerWave = 4;  // shorter waves are not told from noise
constexpr double kNoiseDoubt = 2;   // powers of noise alone are up to some times the mean
constexpr double kMaxDeviation_px = 4;

}  // namespace

Eigen::VectorXd rim_shape(const Eigen::VectorXd& residuals,
                          const std::vector<char>& use,
                          double variance) {
  const Eigen::Index n = residuals.size();
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(n);
  const auto n_used = static_cast<double>(std::ranges::count(use, 1));
  const auto n_waves = static_cast<int>(n / kSectorsPerWave);
  if (n_used < 8 || n_waves < 3) return shape;
  const SectorTurns turns(n);
  Eigen::VectorXcd sums = Eigen::VectorXcd::Zero(n_waves + 1);
  Eigen::VectorXd powers = Eigen::VectorXd::Zero(n_waves + 1);
  for (int k = 2; k <= n_waves; ++k) {
    turns.for_each(k, [&](Eigen::Index i, const std::complex<double>& turn) {
      if (use[static_cast<std::size_t>(i)] == 0) return;
      sums[k] += std::clamp(residuals[i], -kMaxDeviation_px, kMaxDeviation_px) * turn;
    });
    powers[k] = std::norm(sums[k]) / n_used;
  }
  for (int k = 2; k <= n_waves; ++k) {
    const double power =
        powers.segment(std::max(2, k - 1), std::min(3, n_waves - std::max(2, k - 1) + 1)).mean();
    const double gain = 1 - kNoiseDoubt * variance / std::max(power, 1e-12);
    if (gain <= 0) continue;
    const std::complex<double> wave = gain * 2 / static_cast<double>(n) * sums[k];
    turns.for_each(k, [&](Eigen::Index i, const std::complex<double>& turn) {
      shape[i] += (wave * std::conj(turn)).real();
    });
  }
  return shape;
}

}  // namespace panelcal::internal
