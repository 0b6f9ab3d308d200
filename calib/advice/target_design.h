// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/base/frames.h"
#include "calib/panel/fit.h"
#include <Eigen/Core>

namespace panelcal {

/// A target that is to be measured: where the program puts it, and how well it will be seen.
struct DesignTarget {
  Position<frame::Nominal> nominal;
  ObservedAxes axes = ObservedAxes::Both;
  /// Of the measured place, in units of the noise of the series squared; of a slot only its axis
  /// counts.
  Eigen::Matrix2d cov = Eigen::Matrix2d::Identity();
  /// The part of it that the picture has; absent: all.
  std::optional<Eigen::Matrix2d> picture_cov = std::nullopt;
};

/// Covariance of [l00 l01 l10 l11 tx ty].
using MapCovariance = Eigen::Matrix<double, 6, 6>;

/// The part of the noise of targets that a fit hands on to holes; numbers of times, no unit.
///
/// The leverage of a place is the greatest standard deviation of the corrected place in any
/// direction, in units of the noise of the series (DesignTarget::cov):
///
///   leverage(p)^2 = greatest eigenvalue of J(p) cov J(p)',   J(p) = [x y 0 0 1 0; 0 0 x y 0 1]
///
/// It is a norm of what is affine in p, hence convex: over any set of holes it is greatest at a
/// corner of their convex hull, and what lies below a level is convex.
class LeverageMap {
 public:
  explicit LeverageMap(const MapCovariance& cov);

  double operator()(const Position<frame::Nominal>& p) const;
  /// Of the corrected place, in units of the series' noise squared.
  Eigen::Matrix2d covariance(const Position<frame::Nominal>& p) const;

 private:
  /// A quadratic form in (x, y, 1): xx, 2 xy, yy, 2 x, 2 y, 1.
  using Form = Eigen::Matrix<double, 6, 1>;
  static Form form(const MapCovariance& cov, int row, int column);

  Form in_x_;
  Form in_y_;
  Form mixed_;
};

/// Square root of the greater eigenvalue of a covariance.
double greatest_sigma(const Eigen::Matrix2d& cov);

/// The covariance that a fit will have, before anything is measured.
struct PredictedFit {
  PanelModel model = PanelModel::Offset;
  MapCovariance cov;      ///< of the whole map, in units of the series' noise squared
  MapCovariance own_cov;  ///< without what a base correction leaves
  int degrees_of_freedom = 0;
};

struct PredictedFitResult {
  std::optional<PredictedFit> fit;
  FitFailure failure = FitFailure::TooFewTargets;
};

/// The covariance that fit_panel will find if the panel is nearly the drawn one.
///
/// In     targets: where the program has them, and their noise; base_cov: of the map under which
/// they are looked up,
///        in units of this series' noise squared; zero for a base series
/// Out    cov: of the whole map; with a base it holds the part of its error that the nested fit
///        leaves
/// Fails  as fit_panel, on exactly the same designs
/// Cost   O(n)
/// See    tests/calib/advice/target_design_test.cc
PredictedFitResult predict_fit(std::span<const DesignTarget> targets,
                               PanelModel model,
                               const MapCovariance& base_cov = MapCovariance::Zero());

namespace internal {

/// d [l00 l01 l10 l11 tx ty] / d parameters at the drawn panel, where the map is the identity.
ModelJacobian drawn_jacobian(PanelModel model);

/// The weight of a target, cov^-1; 0 for what it does not show.
Eigen::Matrix2d weight(const DesignTarget& target);

/// J' weight J: what a target tells of the six coefficients, whatever the model. `p`: its place, in
/// any frame that is a nominal one moved and scaled.
MapCovariance information(const Eigen::Vector2d& p, const DesignTarget& target);

/// As predict_fit from the sum of the targets' information; `ridge` keeps what they leave open
/// finite. Precondition: coordinates of the size of 1.
MapCovariance covariance_of(const MapCovariance& information,
                            PanelModel model,
                            const MapCovariance& base_cov,
                            double ridge);

}  // namespace internal
}  // namespace panelcal
