// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/distributions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/log_gamma.h"
#include "calib/base/statistics/quadrature.h"

namespace panelcal {
namespace {

/// Of which the exceedance is just above the least double.
constexpr double kFarthest = 37;

double normal_density(double z) {
  return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
}

/// The chance that a standard normal variable lies between, without loss of digits in either tail.
double normal_between(double low, double high) {
  if (low > 0) return normal_exceedance(low) - normal_exceedance(high);
  return normal_exceedance(-high) - normal_exceedance(-low);
}

/// Along principal axes, 0 < s1 <= s2.
double inside_disc(const Eigen::Vector2d& m, double s1, double s2, double radius) {
  constexpr double kReach = 9;
  constexpr int kPoints = 96;
  const auto across = [&](double x) {
    const double c = std::sqrt(std::max(0.0, (radius - x) * (radius + x)));
    return normal_between((-c - m.y()) / s2, (c - m.y()) / s2);
  };
  // If the other axis hardly varies, the integrand is as narrow as s1 and no wider than the disc.
  const double low = std::max(-radius, m.x() - kReach * s1);
  const double high = std::min(radius, m.x() + kReach * s1);
  if (!(high > low)) return 0;
  // With x = r sin(t) the integrand is smooth at the rim of the disc.
  static const internal::Quadrature rule = internal::gauss_legendre(kPoints, -1, 1);
  const double first = std::asin(std::clamp(low / radius, -1.0, 1.0));
  const double half = 0.5 * (std::asin(std::clamp(high / radius, -1.0, 1.0)) - first);
  double sum = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double angle = first + half * (1 + rule.nodes[i]);
    const double x = radius * std::sin(angle);
    const double density = normal_density((x - m.x()) / s1) / s1;
    sum += half * rule.weights[i] * radius * std::cos(angle) * density * across(x);
  }
  return sum;
}

}  // namespace

double normal_exceedance(double z) {
  return 0.5 * std::erfc(z / std::numbers::sqrt2);
}

double normal_of_exceedance(double chance) {
  if (std::isnan(chance)) return chance;
  if (chance > 0.5) return -normal_of_exceedance(1 - chance);
  if (chance <= normal_exceedance(kFarthest)) return kFarthest;
  const double t = std::sqrt(-2 * std::log(chance));
  double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                     (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  constexpr int kSteps = 3;  // from 4.5e-4, each step about cubes the error
  for (int i = 0; i < kSteps; ++i) {
    const double ratio = (normal_exceedance(z) - chance) / normal_density(z);
    z += ratio / (1 - 0.5 * z * ratio);
  }
  return z;
}

double normal_score(double chance_of_less, double chance_of_more) {
  return chance_of_more < chance_of_less ? normal_of_exceedance(chance_of_more)
                                         : -normal_of_exceedance(chance_of_less);
}

double chi_square_of_exceedance(double chance, double degrees_of_freedom) {
  const double a = 0.5 * degrees_of_freedom;
  const auto not_exceeded = [a](double x) {
    constexpr int kMostTerms = 10'000;
    constexpr double kEnough = 1e-15;
    double term = 1;
    double sum = 1;
    for (int n = 1; n < kMostTerms && term > kEnough * sum; ++n) {
      term *= x / (a + n);
      sum += term;
    }
    return std::exp(a * std::log(x) - x - internal::log_gamma(a + 1)) * sum;
  };
  // Half of the value: beyond ten standard deviations and 50 nothing is left.
  double low = 0;
  double high = a + 10 * std::sqrt(a) + 50;
  constexpr int kHalvings = 80;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (not_exceeded(middle) < 1 - chance ? low : high) = middle;
  }
  return low + high;
}

double exceedance_about(const Eigen::VectorXd& mean, const Eigen::MatrixXd& cov, double radius) {
  if (!mean.allFinite() || !cov.allFinite() || !(radius > 0) || mean.size() == 0) return 1;
  if (mean.size() == 1) {
    const double s = std::sqrt(std::max(0.0, cov(0, 0)));
    if (s == 0) return std::abs(mean(0)) > radius ? 1 : 0;
    return normal_exceedance((radius - mean(0)) / s) + normal_exceedance((radius + mean(0)) / s);
  }
  const Eigen::Matrix2d flat = cov.topLeftCorner<2, 2>();
  const internal::PlaneEigensystem eigen = internal::plane_eigensystem(flat);
  const Eigen::Vector2d along = eigen.vectors.transpose() * mean.head<2>();
  // A direction that is nearly exact counts as a millionth of the radius wide.
  const double least = 1e-12 * radius * radius;
  const double s1 = std::sqrt(std::max(least, eigen.values(0)));
  const double s2 = std::sqrt(std::max(least, eigen.values(1)));
  return std::clamp(1 - inside_disc(along, s1, s2, radius), 0.0, 1.0);
}

}  // namespace panelcal
