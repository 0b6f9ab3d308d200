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
constexpr std::array<double, 7> kCorners = {1, 1.5, 2.3, 3.5, 6, 12, 100};
constexpr double kLeastOwn = 0.05;  // of the floor
constexpr double kOwnStep = 1.6;
constexpr int kOwnSteps = 34;  // up to 4e5 floors
/// Student's tails: what is extrapolated from few waves may be several times as much.
constexpr double kOwnDoubt = 0.6;

/// An oval without other waves is a tilt, or one side displaced: half a cosine has 5.6 times as
/// much power in its first wave as in its second.
constexpr double kOvalBound = 4;
constexpr double kLoneOval = 6;

/// The power of k periods beside that of one: as rough edges have it, or as smooth light makes it.
double wave_shape(double k, double corner, bool is_smooth) {
  if (is_smooth) return std::exp((1 - k * k) / (2 * corner * corner));
  const double ratio = (1 + corner * corner) / (k * k + corner * corner);
  return ratio * ratio;
}

/// What a lone oval may hide.
double oval_bound(std::span<const double> powers, double floor) {
  constexpr std::size_t kOthers = 5;
  if (powers.size() < kOthers) return 0;
  double others = 0;
  for (std::size_t i = 1; i < kOthers; ++i) others += powers[i] / (kOthers - 1);
  return powers[0] > kLoneOval * std::max(others, floor) ? kOvalBound * powers[0] : 0;
}

}  // namespace

RimWaves extrapolate_waves(std::span<const double> powers, double floor) {
  const auto cost_of = [&](double own, double corner, bool is_smooth) {
    double cost = 0;
    double k = 2;
    for (const double power : powers) {
      const double s = floor + own * wave_shape(k, corner, is_smooth);
      cost += power / s + std::log(s);
      ++k;
    }
    return cost;
  };
  const double round_cost = cost_of(0, 1, false);
  std::vector<double> costs;
  std::vector<double> owns;
  double least = round_cost;
  for (std::size_t state = 0; state < 2 * kCorners.size(); ++state) {
    double own = kLeastOwn * floor;
    for (int i = 0; i < kOwnSteps; ++i, own *= kOwnStep) {
      costs.push_back(cost_of(own, kCorners[state / 2], state % 2 == 1));
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
  const double bound = oval_bound(powers, floor);
  waves.own = std::max(waves.own, bound);
  waves.first = std::max(waves.first, floor + bound);
  return waves;
}

}  // namespace panelcal::internal
