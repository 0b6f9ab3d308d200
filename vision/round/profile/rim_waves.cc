// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace panelcal::internal {
namespace {

constexpr std::array<double, 7> kCorners = {1, 1.5, 2.3, 3.5, 6, 12, 100};
constexpr double kLeastOwn = 0.05;  // of the floor
constexpr double kOwnStep = 1.6;
constexpr std::size_t kOwnSteps = 34;  // up to 4e5 floors
constexpr double kUnlikely = 30;       ///< of the log likelihood
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

/// Minus the log likelihood of the powers, beside that of all being 1.
class SpectrumCost {
 public:
  SpectrumCost(std::span<const double> powers, double floor)
      : n_(std::min(powers.size(), kMostPowers)), floor_(floor) {
    std::copy_n(powers.begin(), n_, powers_.begin());
  }
  void set_shape(double corner, bool is_smooth) {
    for (std::size_t i = 0; i < n_; ++i) {
      shape_[i] = wave_shape(static_cast<double>(i) + 2, corner, is_smooth);
    }
  }
  double of(double own) const {
    double cost = 0;
    double product = 1;  // of at most 24 numbers below 1e6
    for (std::size_t i = 0; i < n_; ++i) {
      const double s = floor_ + own * shape_[i];
      cost += powers_[i] / s;
      product *= s / floor_;
    }
    return cost + std::log(product);
  }

 private:
  static constexpr std::size_t kMostPowers = 24;
  std::size_t n_;
  double floor_;
  std::array<double, kMostPowers> powers_{};
  std::array<double, kMostPowers> shape_{};
};

/// Bound of the error that a lone oval may hide.
double oval_bound(std::span<const double> powers, double floor) {
  constexpr std::size_t kOthers = 5;
  if (powers.size() < kOthers) return 0;
  double others = 0;
  for (std::size_t i = 1; i < kOthers; ++i) others += powers[i] / (kOthers - 1);
  return powers[0] > kLoneOval * std::max(others, floor) ? kOvalBound * powers[0] : 0;
}

}  // namespace

RimWaves extrapolate_waves(std::span<const double> powers, double floor, double rough_chance) {
  const SpectrumCost cost(powers, floor);
  const double round_cost = cost.of(0);
  std::array<double, 2 * kCorners.size() * kOwnSteps> costs{};
  double least = round_cost;
  std::size_t i_cost = 0;
  for (std::size_t state = 0; state < 2 * kCorners.size(); ++state) {
    SpectrumCost shaped = cost;
    shaped.set_shape(kCorners[state / 2], state % 2 == 1);
    double own = kLeastOwn * floor;
    for (std::size_t i = 0; i < kOwnSteps; ++i, own *= kOwnStep) {
      costs[i_cost] = shaped.of(own);
      least = std::min(least, costs[i_cost++]);
    }
  }
  const double per_state = rough_chance / static_cast<double>(costs.size());
  double sum = (1 - rough_chance) * std::exp(least - round_cost);
  double mean = 0;
  double square = 0;
  double own = kLeastOwn * floor;
  for (std::size_t i = 0; i < costs.size(); ++i, own *= kOwnStep) {
    if (i % kOwnSteps == 0) own = kLeastOwn * floor;
    const double beyond = costs[i] - least;
    if (beyond > kUnlikely) continue;
    const double weight = per_state * std::exp(-beyond);
    sum += weight;
    mean += weight * own;
    square += weight * own * own;
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
