// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/smoothing.h"

#include <cmath>
#include <cstddef>

#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Strengths are as far apart in the log odds of the share that a bending takes up. The range ends
/// at bendings of 1 % and of 3,000 times the noise, and six equations tell the logarithm of a
/// strength to no better than 0.6.
constexpr int kStrengths = 64;
constexpr double kLeastLogOdds = -10;
constexpr double kGreatestLogOdds = 16;

/// Prior probability that a panel is not bent at all. Larger leaves affine panels straighter: a
/// hole errs 3 to 4 % more than by an affine map with this. Smaller is more honest where a bending
/// drowns in the noise: of 95 % ellipses 10 um of bow and 9 targets leave 92 to 93 %.
constexpr double kUnbentPanel = 0.1;

/// The prior of a share, u^(-1/2) (1 - u)^(-3/4), and its integral B(1/2, 1/4).
constexpr double kShareTail = 0.25;
constexpr double kWholePrior = 5.244115108584;

/// More than any mixture asks for: 20 / (e ln 20) = 2.46 of one part that has all the variance.
constexpr double kMaxGrowth = 2.5;

/// Mean over what can bend; coincident targets leave modes that cannot.
double share(double strength, const Eigen::VectorXd& d) {
  return (strength * d.array() / (1 + strength * d.array())).sum() /
         static_cast<double>((d.array() > 0).count());
}

/// The strength at which a bending takes up `wanted` of the data, by bisection of its logarithm.
double strength_of_share(double wanted, const Eigen::VectorXd& d) {
  // The share of the strongest mode bounds that of all from above, that of the weakest from below;
  // weaker ones than rounding are no modes.
  double low = std::log(1e-6 / d.maxCoeff());
  double high = std::log(1e18 / d.maxCoeff());
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (share(std::exp(middle), d) < wanted ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

Eigen::VectorXd Smoothing::shrinkage_variance() const {
  const Eigen::VectorXd mean = mean_shrinkage();
  return (shrinkage.array().square().matrix() * weight).array() - mean.array().square();
}

Smoothing weigh_strengths(const Eigen::VectorXd& z, const Eigen::VectorXd& d) {
  Smoothing out;
  out.strength.resize(kStrengths + 1);
  out.shrinkage.resize(d.size(), kStrengths + 1);
  Eigen::VectorXd log_weight(kStrengths + 1);
  constexpr double kStep = (kGreatestLogOdds - kLeastLogOdds) / kStrengths;
  for (int k = 0; k <= kStrengths; ++k) {
    const double odds = std::exp(kLeastLogOdds + (k - 0.5) * kStep);
    const double u = odds / (1 + odds);
    const double s = k == 0 ? 0 : strength_of_share(u, d);
    const Eigen::ArrayXd variance = 1 + s * d.array();
    const double density = std::sqrt(u) * std::pow(1 - u, kShareTail) / kWholePrior;  // of log odds
    const double prior = k == 0 ? kUnbentPanel : (1 - kUnbentPanel) * kStep * density;
    out.strength[k] = s;
    out.shrinkage.col(k) = (s * d.array() / variance).matrix();
    log_weight[k] = std::log(prior) - 0.5 * (variance.log() + z.array().square() / variance).sum();
  }
  out.weight = (log_weight.array() - log_weight.maxCoeff()).exp();
  out.weight /= out.weight.sum();
  return out;
}

double growth_to_95_percent(const Eigen::Matrix2d& noise,
                            std::span<const Eigen::Matrix2d> bent,
                            const Eigen::VectorXd& weight) {
  constexpr double kOutside = 0.05;
  Eigen::Matrix2d mean = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < bent.size(); ++k) {
    mean += weight[static_cast<Eigen::Index>(k)] * bent[k];
  }
  const auto outside = [&](double growth) {
    const Eigen::Matrix2d inverse = (noise + growth * mean).inverse();
    double sum = 0;
    for (std::size_t k = 0; k < bent.size(); ++k) {
      const double variance = 0.5 * (inverse * (noise + bent[k])).trace();
      if (variance > 0) {
        sum += weight[static_cast<Eigen::Index>(k)] * std::exp(std::log(kOutside) / variance);
      }
    }
    return sum;
  };
  double low = 1;
  double high = kMaxGrowth;
  for (int i = 0; i < 14; ++i) {  // to 1e-4
    const double middle = std::sqrt(low * high);
    (outside(middle) > kOutside ? low : high) = middle;
  }
  return low;
}

}  // namespace panelcal::internal
