// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/smoothing.h"

#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

/// Steps of the share that the prior is uniform in. The likelihood changes little from one to the
/// next: 64 instead of these moves no map by a hundredth of its sigma.
constexpr int kSteps = 32;

/// Prior probability that a panel is not bent at all. Larger leaves affine panels straighter: with
/// 0.5 a hole errs 1 to 2 % more than by an affine map, with this 4 %, with 0 8 %. Smaller is more
/// honest where a bending drowns in the noise: of 95 % ellipses 10 um of bow and 9 targets leave
/// 87, 92 and 94 %.
constexpr double kUnbentPanel = 0.2;

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
  out.strength.resize(kSteps + 1);
  out.shrinkage.resize(d.size(), kSteps + 1);
  Eigen::VectorXd log_weight(kSteps + 1);
  for (int k = 0; k <= kSteps; ++k) {
    // Denser towards both ends: a panel that is bent far beyond the noise has its share within a
    // hundredth of 1, and there the strength is what matters.
    const double angle_rad = std::numbers::pi * (k - 0.5) / kSteps;
    const double s = k == 0 ? 0 : strength_of_share(0.5 * (1 - std::cos(angle_rad)), d);
    const Eigen::ArrayXd variance = 1 + s * d.array();
    const double step = 0.5 * std::numbers::pi / kSteps * std::sin(angle_rad);
    const double prior = k == 0 ? kUnbentPanel : (1 - kUnbentPanel) * step;
    out.strength[k] = s;
    out.shrinkage.col(k) = (s * d.array() / variance).matrix();
    log_weight[k] = std::log(prior) - 0.5 * (variance.log() + z.array().square() / variance).sum();
  }
  out.weight = (log_weight.array() - log_weight.maxCoeff()).exp();
  out.weight /= out.weight.sum();
  return out;
}

}  // namespace panelcal::internal
