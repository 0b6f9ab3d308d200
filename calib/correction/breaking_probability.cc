// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/breaking_probability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace panelcal {
namespace {

using std::numbers::pi;

/// Below this part of the larger sigma the integrand's dip becomes too narrow for the angle.
constexpr double kLeastRatio = 0.1;

constexpr double kLeastProbability = 1e-20;

/// The trapezoidal rule on (0, pi) of the double angle: n intervals and the cosine of one.
struct Steps {
  int n;
  double cosine;
};

/// Enough for an error below 1e-8 of the result: found by halving the step for ratios 0.05 to 40
/// and sigma_ratio 0 to 1; the test holds the outcome against another integral. `ratio` is the
/// radius over the larger sigma.
Steps steps_of(double ratio, double sigma_ratio) {
  struct Row {
    double least_sigma_ratio;
    Steps steps;
  };
  // Nearly all holes are here.
  constexpr std::array<Row, 4> kUsual = {{{0.9, {6, 0.86602540378443864676}},
                                          {0.7, {8, 0.92387953251128675613}},
                                          {0.5, {10, 0.95105651629515357212}},
                                          {0, {16, 0.98078528040323044913}}}};
  constexpr double kFarOut = 7.5;  // from here on the peak becomes too narrow for them
  if (ratio < kFarOut && std::max(ratio, 4 * sigma_ratio) >= 2) {
    for (const Row& row : kUsual) {
      if (sigma_ratio >= row.least_sigma_ratio) return row.steps;
    }
  }
  const int n = ratio < kFarOut ? static_cast<int>(std::ceil(32 / std::max(ratio, sigma_ratio)))
                                : static_cast<int>(std::ceil(2 * ratio));
  return {n, std::cos(pi / n)};
}

/// The integral over the angle. Precondition: ratio > 0.
double by_angle(double ratio, double sigma_ratio) {
  const double small_2 = sigma_ratio * sigma_ratio;
  const double mean = (1 + small_2) / 2;
  const double half = (1 - small_2) / 2;
  const double b = ratio * ratio / 2;
  // A bound of the integral: no real errors are normal so far out.
  if (b > -std::log(kLeastProbability)) return 0;
  const auto [n, step_cos] = steps_of(ratio, sigma_ratio);
  double previous = step_cos;  // of one step back
  double current = 1;
  constexpr double kUnseen = 1e-10;
  double sum = std::exp(-b) / 2;
  for (int i = 1; i < n; ++i) {
    const double next = 2 * step_cos * current - previous;
    previous = current;
    current = next;
    const double term = std::exp(-b / (mean + half * current));
    sum += term;
    // The terms fall: what is left cannot be seen.
    if (term < kUnseen * sum) return sum / n;
  }
  if (small_2 > 0) sum += std::exp(-b / small_2) / 2;
  return sum / n;
}

/// One less the probability of staying inside: strips across the longer axis. Only where nearly all
/// is outside, for else the difference would lose its digits.
double by_strips(double ratio, double sigma_ratio) {
  constexpr int kStrips = 1024;
  const double inner = ratio / (sigma_ratio * std::numbers::sqrt2);  // may be infinite
  double sum = 0;
  for (int i = 0; i < kStrips; ++i) {
    const double angle = pi * (i + 0.5) / kStrips - pi / 2;
    const double x = ratio * std::sin(angle);
    const double y = std::cos(angle);
    sum += y * std::exp(-x * x / 2) * std::erf(y * inner);
  }
  return 1 - ratio * sum * pi / kStrips / std::sqrt(2 * pi);
}

/// Above this ratio of the sigmas the series converges faster than the mean.
constexpr double kRound = 0.5;

/// sqrt(2/pi) E, an ellipse's perimeter (Gauss and Kummer) over 4 sqrt(pi/2); to 1e-10.
double by_series(double sigma_ratio) {
  const double root = (1 - sigma_ratio) / (1 + sigma_ratio);
  const double h = root * root;
  const double sum =
      1 +
      h / 4 *
          (1 + h / 16 * (1 + h / 4 * (1 + h * 25 / 64 * (1 + h * 49 / 100 * (1 + h * 9 / 16)))));
  return std::sqrt(pi / 8) * (1 + sigma_ratio) * sum;
}

double exceedance(double ratio, double sigma_ratio) {
  if (!(ratio > 0)) return 1;
  return ratio < kLeastRatio ? by_strips(ratio, sigma_ratio) : by_angle(ratio, sigma_ratio);
}

double ratio_of(const PrincipalSigmas& sigmas) {
  return sigmas.large > Length() ? sigmas.small / sigmas.large : 0;
}

}  // namespace

PrincipalSigmas principal_sigmas(const Eigen::Matrix2d& cov_mm2) {
  const double mean = (cov_mm2(0, 0) + cov_mm2(1, 1)) / 2;
  const double half = (cov_mm2(0, 0) - cov_mm2(1, 1)) / 2;
  const double apart = std::sqrt(half * half + cov_mm2(0, 1) * cov_mm2(0, 1));
  // The smaller one by the determinant: a difference would lose a thin ellipse's digits.
  const double large = std::max(0.0, mean + apart);
  const double det = cov_mm2(0, 0) * cov_mm2(1, 1) - cov_mm2(0, 1) * cov_mm2(0, 1);
  const double small = large > 0 ? std::max(0.0, det / large) : 0;
  return {mm(std::sqrt(large)), mm(std::sqrt(std::min(small, large)))};
}

double breaking_probability(const Eigen::Matrix2d& cov_mm2, Length radius) {
  if (!cov_mm2.allFinite()) return 1;
  if (!(radius >= Length())) return 1;
  const PrincipalSigmas sigmas = principal_sigmas(cov_mm2);
  if (!(sigmas.large > Length())) return 0;
  return std::clamp(exceedance(radius / sigmas.large, ratio_of(sigmas)), 0.0, 1.0);
}

Length mean_radial_error(const PrincipalSigmas& sigmas) {
  const double start = ratio_of(sigmas);
  // sqrt(2/pi) E = sqrt(2/pi) K (1 - sum), K = pi / (2 a): infinite for a line, where E is 1.
  constexpr double kLine = 1e-9;
  if (start < kLine) return std::sqrt(2 / pi) * sigmas.large;
  if (start > kRound) return by_series(start) * sigmas.large;
  double a = 1;
  double b = start;
  double c_2 = 1 - b * b;
  double weight = 0.5;
  double sum = weight * c_2;
  // Quadratic: 1e-9 of a line takes eight rounds.
  for (int round = 0; round < 12 && c_2 > 1e-17; ++round) {
    const double c = (a - b) / 2;
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
    c_2 = c * c;
    weight *= 2;
    sum += weight * c_2;
  }
  return std::sqrt(pi / 2) * (1 - sum) / a * sigmas.large;
}

Length radius_exceeded(const PrincipalSigmas& sigmas, double probability) {
  if (!(sigmas.large > Length()) || !(probability < 1)) return Length();
  const double sigma_ratio = ratio_of(sigmas);
  // A circle's radius holds more than any ellipse inside it.
  double low = 0;
  double high = std::sqrt(-2 * std::log(probability));
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings && high - low > 1e-12 * high; ++i) {
    const double middle = (low + high) / 2;
    (exceedance(middle, sigma_ratio) > probability ? low : high) = middle;
  }
  return (low + high) / 2 * sigmas.large;
}

}  // namespace panelcal
