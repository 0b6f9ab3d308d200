// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/run_length.h"

#include <cmath>
#include <numbers>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/quadrature.h"
#include <Eigen/LU>

namespace panelcal {
namespace {

/// Enough for eight digits where the chart is 12 standard deviations of a step wide.
constexpr int kPoints = 64;

/// The density of |x| at s, x ~ N(a e1, I) in n dimensions: a mixture of central ones with Poisson
/// weights.
double noncentral_chi_density(int n, double a, double s) {
  constexpr double kRounding = 1e-17;
  const double half_n = 0.5 * n;
  double term = std::exp(-0.5 * (a * a + s * s) + (n - 1) * std::log(s) -
                         (half_n - 1) * std::numbers::ln2 - std::lgamma(half_n));
  double sum = term;
  const double step = 0.25 * a * a * s * s;
  for (int j = 0;; ++j) {
    const double ratio = step / ((j + 1) * (half_n + j));
    term *= ratio;
    sum += term;
    // The terms rise as long as the ratio is above 1.
    if (ratio < 0.5 && term <= kRounding * sum) return sum;
  }
}

/// The limit at which an increasing run length reaches the wanted one.
template <class RunLength>
double solve_run_length(const RunLength& run_length, double nights, double low, double high) {
  constexpr double kEnough = 1e-9;
  while (high - low > kEnough) {
    const double middle = 0.5 * (low + high);
    (run_length(middle) < nights ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double ewma_run_length(int n_axes, double weight, double limit) {
  // In units of weight: v' = (1 - weight) v + u.
  const double widest = limit / std::sqrt(weight * (2 - weight));
  const auto rule = internal::gauss_legendre(kPoints, 0, widest);
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(kPoints, kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const double from = (1 - weight) * rule.nodes[static_cast<std::size_t>(i)];
    for (int j = 0; j < kPoints; ++j) {
      const auto k = static_cast<std::size_t>(j);
      system(i, j) -= rule.weights[k] * noncentral_chi_density(n_axes, from, rule.nodes[k]);
    }
  }
  const Eigen::VectorXd at_nodes = system.partialPivLu().solve(Eigen::VectorXd::Ones(kPoints));
  double from_zero = 1;
  for (int j = 0; j < kPoints; ++j) {
    const auto k = static_cast<std::size_t>(j);
    from_zero += rule.weights[k] * noncentral_chi_density(n_axes, 0, rule.nodes[k]) * at_nodes(j);
  }
  return from_zero;
}

double cusum_run_length(double allowance, double limit) {
  const auto rule = internal::gauss_legendre(kPoints, 0, limit);
  // The last unknown is the run length from zero, where the sum stays with a chance of its own.
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(kPoints + 1, kPoints + 1);
  for (int i = 0; i <= kPoints; ++i) {
    const double from = i < kPoints ? rule.nodes[static_cast<std::size_t>(i)] : 0;
    for (int j = 0; j < kPoints; ++j) {
      const auto k = static_cast<std::size_t>(j);
      const double u = rule.nodes[k] - from + allowance;
      system(i, j) -= rule.weights[k] * std::exp(-0.5 * u * u) / std::sqrt(2 * std::numbers::pi);
    }
    system(i, kPoints) -= normal_exceedance(from - allowance);
  }
  return system.partialPivLu().solve(Eigen::VectorXd::Ones(kPoints + 1))(kPoints);
}

double ewma_limit(int n_axes, double weight, double nights) {
  constexpr double kWidest = 9;
  return solve_run_length(
      [&](double limit) { return ewma_run_length(n_axes, weight, limit); }, nights, 1e-3, kWidest);
}

double cusum_limit(double allowance, double nights) {
  constexpr double kHighest = 30;
  return solve_run_length(
      [&](double limit) { return cusum_run_length(allowance, limit); }, nights, 1e-3, kHighest);
}

}  // namespace panelcal
