// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal::test {

/// A smooth bending that is no affine map and no spline: low polynomials and waves as long as the
/// panel, drawn at random, of 500 x 400 mm.
class Bow {
 public:
  Bow(Random& random, double size_mm) : size_mm_(size_mm) {
    for (double& c : coefficients_.reshaped()) c = 0.5 * random.normal();
  }

  Eigen::Vector2d operator()(const Eigen::Vector2d& p_mm) const {
    const double x = (p_mm.x() - 250) / 250;
    const double y = (p_mm.y() - 200) / 200;
    Eigen::Matrix<double, 9, 1> terms;
    terms << x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y,
        std::sin(2.5 * x + 1) * std::cos(2 * y), std::cos(3 * y - 0.5 * x);
    return size_mm_ * coefficients_ * terms;
  }

 private:
  Eigen::Matrix<double, 2, 9> coefficients_;
  double size_mm_;
};

inline constexpr double kBowedSigma_mm = 0.005;

inline Coefficients affine_truth(Random& random) {
  return internal::coefficients(PanelModel::Affine, random_parameters(random, PanelModel::Affine));
}

/// n targets anywhere on a bowed panel.
inline std::vector<RawPair> bowed_pairs(Random& random,
                                        int n,
                                        const Coefficients& truth,
                                        const Bow& bow) {
  auto pairs = random_pairs(random, n, truth, kBowedSigma_mm, true);
  for (RawPair& pair : pairs) pair.to_mm += bow(pair.from_mm);
  return pairs;
}

/// The parameters' panel with these deformations instead, as far as the model has them.
inline Coefficients deformed(
    PanelModel model, ModelParameters p, double theta_rad, double sx, double sy, double shear) {
  const double c = std::cos(theta_rad);
  const double s = std::sin(theta_rad);
  if (model == PanelModel::Rigid) p[0] = theta_rad;
  if (model == PanelModel::Similarity) p.head<2>() << sx * c, sx * s;
  if (model == PanelModel::Stretch) p.head<3>() << theta_rad, sx, sy;
  if (model == PanelModel::Affine) {
    p.head<4>() << sx * c, c * shear - s * sy, sx * s, s * shear + c * sy;
  }
  return internal::coefficients(model, p);
}

inline Eigen::Vector2d random_place(Random& random) {
  return {random.uniform(0, 500), random.uniform(0, 400)};
}

/// n targets on the rim of a panel, about evenly, as panels carry them.
inline std::vector<RawPair> rim_pairs(Random& random,
                                      int n,
                                      const Coefficients& truth,
                                      double sigma_mm) {
  std::vector<RawPair> pairs;
  for (int i = 0; i < n; ++i) {
    const double angle_rad = 2 * std::numbers::pi * (i + random.uniform(0, 0.5)) / n;
    const Eigen::Vector2d from_mm(250 + 240 * std::cos(angle_rad), 200 + 190 * std::sin(angle_rad));
    const Eigen::Matrix2d cov_mm2 = random_covariance(random, sigma_mm);
    const Eigen::Vector2d to_mm = mapped(truth, from_mm) + draw(random, cov_mm2);
    pairs.push_back({from_mm, to_mm, cov_mm2});
  }
  return pairs;
}

/// Inside the ellipse that should hold 95 % of the truths.
inline bool is_in_ellipse(const Eigen::Vector2d& error, const Eigen::Matrix2d& cov) {
  const double det = cov(0, 0) * cov(1, 1) - cov(0, 1) * cov(1, 0);
  const double squared = (cov(1, 1) * error.x() * error.x() + cov(0, 0) * error.y() * error.y() -
                          2 * cov(0, 1) * error.x() * error.y()) /
                         det;
  return det > 0 && squared <= -2 * std::log(0.05);
}

}  // namespace panelcal::test
