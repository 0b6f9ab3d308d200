// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/bending/bending_average.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

namespace panelcal::internal {
namespace {

/// A kernel and how likely it is beforehand.
struct PriorKernel {
  BendingKernel kernel;
  double weight;
};
constexpr std::array kPriorKernels = {PriorKernel{BendingKernel::Matern12, 4},
                                      PriorKernel{BendingKernel::Matern32, 1},
                                      PriorKernel{BendingKernel::Gaussian, 1}};
constexpr double kAverageLengthStep = 2;
/// Below it what bends differs from scatter in nothing that readings show.
constexpr double kShortestAverage = 0.35;
/// Of all weight.
constexpr double kKeptWeight = 0.97;

/// Bendings that are solved for: each costs as much as the cube of the readings' number.
std::size_t most_shares(Eigen::Index n_readings) {
  if (n_readings <= 40) return 24;
  if (n_readings <= 150) return 10;
  return n_readings <= 300 ? 6 : 4;
}

}  // namespace

std::vector<BendingShare> bending_average(const BendingLikelihood& likelihood) {
  std::vector<BendingShare> out;
  double least = std::numeric_limits<double>::infinity();
  for (const PriorKernel& prior : kPriorKernels) {
    for (const double length : likelihood.lengths(kAverageLengthStep, kShortestAverage)) {
      const Bending bending = likelihood.mean_strength(prior.kernel, length, kEvidenceShare);
      out.push_back({bending, prior.weight});
      least = std::min(least, bending.minus_2_log_likelihood);
    }
  }
  double sum = 0;
  for (BendingShare& share : out) {
    const double worse = share.bending.minus_2_log_likelihood - least;
    const double likelihood_ratio = std::exp(-0.5 * kEvidenceShare * worse);
    // What is not finite explains nothing.
    share.weight = likelihood_ratio >= 0 ? share.weight * likelihood_ratio : 0;
    sum += share.weight;
  }
  std::ranges::stable_sort(out, std::greater(), &BendingShare::weight);
  std::size_t n = 0;
  double kept = 0;
  while (n < out.size() && n < most_shares(likelihood.n_readings()) && kept < kKeptWeight * sum) {
    kept += out[n++].weight;
  }
  out.resize(n);
  for (BendingShare& share : out) share.weight /= kept;
  return out;
}

}  // namespace panelcal::internal
