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

/// What a rim's own waves have beyond the floor, in steps.
using OwnSteps = std::array<double, kOwnSteps>;

OwnSteps own_steps(double floor) {
  OwnSteps own{};
  own[0] = kLeastOwn * floor;
  for (std::size_t i = 1; i < kOwnSteps; ++i) own[i] = kOwnStep * own[i - 1];
  return own;
}

/// Minus the log likelihood of powers, beside that of all being 1.
class SpectrumCost {
 public:
  SpectrumCost(std::span<const double> powers, double floor)
      : powers_(powers.first(std::min(powers.size(), kMostPowers))), floor_(floor) {}

  double of_floor() const {
    double cost = 0;
    for (const double power : powers_) cost += power / floor_;
    return cost;
  }

  /// For each step of own waves of a shape.
  OwnSteps of(const OwnSteps& own, double corner, bool is_smooth) const {
    OwnSteps costs{};
    OwnSteps products;  // of at most 24 numbers below 1e6
    products.fill(1);
    for (std::size_t k = 0; k < powers_.size(); ++k) {
      const double shape = wave_shape(static_cast<double>(k) + 2, corner, is_smooth) / floor_;
      const double power = powers_[k] / floor_;
      for (std::size_t i = 0; i < kOwnSteps; ++i) {
        const double s = 1 + own[i] * shape;
        costs[i] += power / s;
        products[i] *= s;
      }
    }
    for (std::size_t i = 0; i < kOwnSteps; ++i) costs[i] += std::log(products[i]);
    return costs;
  }

 private:
  static constexpr std::size_t kMostPowers = 24;
  std::span<const double> powers_;
  double floor_;
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
  constexpr std::size_t kShapes = 2 * kCorners.size();
  const SpectrumCost cost(powers, floor);
  const double round_cost = cost.of_floor();
  const OwnSteps own = own_steps(floor);
  std::array<OwnSteps, kShapes> costs{};
  double least = round_cost;
  for (std::size_t shape = 0; shape < kShapes; ++shape) {
    costs[shape] = cost.of(own, kCorners[shape / 2], shape % 2 == 1);
    least = std::min(least, *std::ranges::min_element(costs[shape]));
  }
  const double per_state = rough_chance / static_cast<double>(kShapes * kOwnSteps);
  double sum = (1 - rough_chance) * std::exp(least - round_cost);
  double mean = 0;
  double square = 0;
  for (const OwnSteps& of_shape : costs) {
    for (std::size_t i = 0; i < kOwnSteps; ++i) {
      const double beyond = of_shape[i] - least;
      if (beyond > kUnlikely) continue;
      const double weight = per_state * std::exp(-beyond);
      sum += weight;
      mean += weight * own[i];
      square += weight * own[i] * own[i];
    }
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
