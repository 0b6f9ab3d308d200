// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/panel/fit.h"
#include "calib/panel/model.h"
#include <Eigen/Core>

namespace panelcal {

/// Prints a failure for GoogleTest.
inline void PrintTo(FitFailure failure, std::ostream* out) {
  constexpr const char* kNames[] = {"TooFewTargets", "Degenerate", "BadCovariance"};
  *out << kNames[static_cast<int>(failure)];
}

}  // namespace panelcal

namespace panelcal::test {

using internal::Coefficients;
using internal::ModelParameters;
using internal::RawFit;
using internal::RawFitResult;
using internal::RawPair;

inline constexpr PanelModel kAllModels[] = {PanelModel::Offset,
                                            PanelModel::Rigid,
                                            PanelModel::Similarity,
                                            PanelModel::Stretch,
                                            PanelModel::Affine};

inline Eigen::Matrix2d rotation(double angle_rad) {
  Eigen::Matrix2d r;
  r << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
  return r;
}

/// A target seen where it should be, with a sigma of 1 um.
inline RawPair seen_exactly(double x_mm, double y_mm) {
  return {{x_mm, y_mm}, {x_mm, y_mm}, 1e-6 * Eigen::Matrix2d::Identity()};
}

/// The same for a slot that shows its x only, and for one that shows its y only.
inline RawPair x_at(double x_mm, double y_mm) {
  RawPair pair = seen_exactly(x_mm, y_mm);
  pair.axes = ObservedAxes::X;
  return pair;
}
inline RawPair y_at(double x_mm, double y_mm) {
  RawPair pair = seen_exactly(x_mm, y_mm);
  pair.axes = ObservedAxes::Y;
  return pair;
}

/// A covariance whose axes point anywhere and differ by up to 5 to 1.
inline Eigen::Matrix2d random_covariance(Random& random, double sigma_mm) {
  const double long_mm = sigma_mm * random.uniform(0.5, 2.0);
  const double short_mm = long_mm * random.uniform(0.2, 1.0);
  const Eigen::Matrix2d r = rotation(random.uniform(0, std::numbers::pi));
  const Eigen::Vector2d variances(long_mm * long_mm, short_mm * short_mm);
  const Eigen::Matrix2d cov = r * variances.asDiagonal() * r.transpose();
  return 0.5 * (cov + cov.transpose());
}

/// One draw of an error with the covariance `cov`.
inline Eigen::Vector2d draw(Random& random, const Eigen::Matrix2d& cov) {
  const double l00 = std::sqrt(cov(0, 0));
  const double l10 = cov(1, 0) / l00;
  const double l11 = std::sqrt(cov(1, 1) - l10 * l10);
  const double u = random.normal();
  const double v = random.normal();
  return {l00 * u, l10 * u + l11 * v};
}

/// Parameters such as a panel on a table has: a few mm off, a degree askew, 0.1 % stretched.
inline ModelParameters random_parameters(Random& random, PanelModel model) {
  ModelParameters p(parameter_count(model));
  const double theta_rad = random.uniform(-0.02, 0.02);
  const double sx = random.uniform(0.999, 1.001);
  const double sy = random.uniform(0.999, 1.001);
  const double shear = random.uniform(-0.001, 0.001);
  const double tx_mm = random.uniform(-5, 5);
  const double ty_mm = random.uniform(-5, 5);
  const double c = std::cos(theta_rad);
  const double s = std::sin(theta_rad);
  switch (model) {
    case PanelModel::Offset:
      p << tx_mm, ty_mm;
      break;
    case PanelModel::Rigid:
      p << theta_rad, tx_mm, ty_mm;
      break;
    case PanelModel::Similarity:
      p << sx * c, sx * s, tx_mm, ty_mm;
      break;
    case PanelModel::Stretch:
      p << theta_rad, sx, sy, tx_mm, ty_mm;
      break;
    case PanelModel::Affine:
      p << sx * c, c * shear - s * sy, sx * s, s * shear + c * sy, tx_mm, ty_mm;
      break;
  }
  return p;
}

inline Eigen::Vector2d mapped(const Coefficients& a, const Eigen::Vector2d& from_mm) {
  return {a[0] * from_mm.x() + a[1] * from_mm.y() + a[4],
          a[2] * from_mm.x() + a[3] * from_mm.y() + a[5]};
}

/// The same targets and slots, seen where `truth` puts them.
inline std::vector<RawPair> seen_through(std::vector<RawPair> pairs, const Coefficients& truth) {
  for (RawPair& pair : pairs) pair.to_mm = mapped(truth, pair.from_mm);
  return pairs;
}

/// n targets anywhere on a panel of 500 x 400 mm, seen with errors if `noisy`.
inline std::vector<RawPair> random_pairs(
    Random& random, int n, const Coefficients& truth, double sigma_mm, bool noisy) {
  std::vector<RawPair> pairs;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d from_mm(random.uniform(0, 500), random.uniform(0, 400));
    const Eigen::Matrix2d cov_mm2 = random_covariance(random, sigma_mm);
    const Eigen::Vector2d error_mm = draw(random, cov_mm2);
    Eigen::Vector2d to_mm = mapped(truth, from_mm);
    if (noisy) to_mm += error_mm;
    pairs.push_back({from_mm, to_mm, cov_mm2});
  }
  return pairs;
}

/// n slots that show x, n that show y, by turns and spread over the panel's edges as panels carry
/// them, and n_points targets that show both. What a slot does not show is no number.
inline std::vector<RawPair> random_slots(
    Random& random, int n, int n_points, const Coefficients& truth, double sigma_mm, bool noisy) {
  std::vector<RawPair> pairs = random_pairs(random, 2 * n + n_points, truth, sigma_mm, noisy);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 2 * n; ++i) {
    RawPair& pair = pairs[static_cast<std::size_t>(i)];
    const double angle_rad = std::numbers::pi * (i + random.uniform(0, 0.5)) / n;
    const Eigen::Vector2d from_mm(250 + 240 * std::cos(angle_rad), 200 + 190 * std::sin(angle_rad));
    pair.to_mm += mapped(truth, from_mm) - mapped(truth, pair.from_mm);
    pair.from_mm = from_mm;
    const int hidden = i % 2 == 0 ? 1 : 0;
    pair.axes = i % 2 == 0 ? ObservedAxes::X : ObservedAxes::Y;
    pair.to_mm[hidden] = kNan;
    pair.cov_mm2.row(hidden).setConstant(kNan);
    pair.cov_mm2.col(hidden).setConstant(kNan);
  }
  return pairs;
}

inline Coefficients coefficients_of(const RawFit& fit) {
  Coefficients a;
  a << fit.linear(0, 0), fit.linear(0, 1), fit.linear(1, 0), fit.linear(1, 1),
      fit.translation_mm.x(), fit.translation_mm.y();
  return a;
}

/// The block diagonal covariance of all measurements, in the order of RawFit::gain's columns.
inline Eigen::MatrixXd stacked_covariance(const std::vector<RawPair>& pairs) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd cov = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    cov.block<2, 2>(2 * i, 2 * i) = pairs[static_cast<std::size_t>(i)].cov_mm2;
  }
  return cov;
}

}  // namespace panelcal::test
