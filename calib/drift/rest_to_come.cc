// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/rest_to_come.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace panelcal {
namespace {

constexpr int kRestTimeConstants = 60;
constexpr double kShortest = 0.02;  ///< of the time from the first sample to the last
constexpr double kLongest = 2;
constexpr double kFine = 1.0001;  ///< steps of the time constant that are small enough
constexpr double kSigmas = 2;
constexpr double kChiSquare = 9;

/// The best c for a time constant.
struct Guess {
  double tau_s = 0;
  double chi_square = 0;
  double rest = 0;  ///< with kSigmas
};

Guess guess(std::span<const WarmUpSample> samples, double first_s, double last_s, double tau_s) {
  double s = 0;
  double sx = 0;
  double sxx = 0;
  Eigen::VectorXd sy = Eigen::VectorXd::Zero(samples.front().value.size());
  Eigen::VectorXd sxy = sy;
  double syy = 0;
  // As large as it was at the first sample, so that nothing underflows.
  const auto decay = [&](double t_s) { return std::exp(-(t_s - first_s) / tau_s); };
  for (const WarmUpSample& sample : samples) {
    const double w = 1 / (sample.sigma * sample.sigma);
    const double x = decay(sample.since_start.in_s());
    const Eigen::VectorXd y = sample.value - samples.front().value;
    s += w;
    sx += w * x;
    sxx += w * x * x;
    sy += w * y;
    sxy += w * x * y;
    syy += w * y.squaredNorm();
  }
  const double spread = sxx - sx * sx / s;
  if (!(spread > 0)) return {tau_s, 0, std::numeric_limits<double>::infinity()};
  const Eigen::VectorXd c = (sxy - sx / s * sy) / spread;
  Guess out;
  out.tau_s = tau_s;
  out.chi_square = syy - sy.squaredNorm() / s - spread * c.squaredNorm();
  out.rest = decay(last_s) * (c.norm() + kSigmas / std::sqrt(spread));
  return out;
}

}  // namespace

double most_to_come(std::span<const WarmUpSample> samples) {
  constexpr double kNobodyKnows = std::numeric_limits<double>::infinity();
  if (samples.size() < 3) return kNobodyKnows;
  const auto [first, last] = std::ranges::minmax(
      samples, {}, [](const WarmUpSample& sample) { return sample.since_start.in_s(); });
  const double first_s = first.since_start.in_s();
  const double last_s = last.since_start.in_s();
  if (!(last_s > first_s)) return kNobodyKnows;
  const double whole_s = last_s - first_s;
  std::vector<Guess> guesses;
  const auto try_all = [&](double shortest_s, double longest_s) {
    for (int i = 0; i < kRestTimeConstants; ++i) {
      const double part = static_cast<double>(i) / (kRestTimeConstants - 1);
      const double tau_s = shortest_s * std::pow(longest_s / shortest_s, part);
      guesses.push_back(guess(samples, first_s, last_s, tau_s));
    }
    return *std::ranges::min_element(guesses, {}, &Guess::chi_square);
  };
  Guess best = try_all(kShortest * whole_s, kLongest * whole_s);
  // A long way tells its time constant more sharply than the first steps are.
  for (double step = std::pow(kLongest / kShortest, 1.0 / (kRestTimeConstants - 1)); step > kFine;
       step = std::pow(step, 2.0 / (kRestTimeConstants - 1))) {
    best = try_all(best.tau_s / step, std::min(best.tau_s * step, kLongest * whole_s));
  }
  double most = 0;
  for (const Guess& one : guesses) {
    // One that is no number may be anything.
    if (!(one.chi_square > best.chi_square + kChiSquare)) most = std::max(most, one.rest);
  }
  return most;
}

}  // namespace panelcal
