// SPDX-License-Identifier: Apache-2.0
#include "vision/round/rim_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace panelcal::internal {
namespace {

/// Chance, before anything is seen, that a rim has a shape of its own that matters.
constexpr double kRoughPrior = 0.1;
constexpr std::array<double, 8> kCorners = {0.7, 1, 1.5, 2.3, 3.5, 6, 12, 100};
constexpr double kLeastOwn = 0.05;  // of the floor
constexpr double kOwnStep = 1.6;
constexpr int kOwnSteps = 34;  // up to 4e5 floors
/// Student's tails: what is extrapolated from few waves may be several times as much.
constexpr double kOwnDoubt = 0.6;

}  // namespace

RimWaves extrapolate_waves(std::span<const double> powers, double floor) {
  const auto cost_of = [&](double own, double corner) {
    double cost = 0;
    double k = 2;
    for (const double power : powers) {
      const double shape = (1 + corner * corner) / (k * k + corner * corner);
      const double s = floor + own * shape * shape;
      cost += power / s + std::log(s);
      ++k;
    }
    return cost;
  };
  const double round_cost = cost_of(0, 1);
  std::vector<double> costs;
  std::vector<double> owns;
  double least = round_cost;
  for (const double corner : kCorners) {
    double own = kLeastOwn * floor;
    for (int i = 0; i < kOwnSteps; ++i, own *= kOwnStep) {
      costs.push_back(cost_of(own, corner));
      owns.push_back(own);
      least = std::min(least, costs.back());
    }
  }
  const double per_state = kRoughPrior / static_cast<double>(costs.size());
  double sum = (1 - kRoughPrior) * std::exp(least - round_cost);
  double mean = 0;
  double square = 0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const double weight = per_state * std::exp(least - costs[i]);
    sum += weight;
    mean += weight * owns[i];
    square += weight * owns[i] * owns[i];
  }
  RimWaves waves;
  waves.own = mean / sum;
  const double spread = std::sqrt(std::max(0.0, square / sum - waves.own * waves.own));
  waves.first = floor + waves.own + kOwnDoubt * std::min(spread, 2 * waves.own);
  return waves;
}

}  // namespace panelcal::internal
