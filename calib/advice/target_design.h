// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calib/base/frames.h"
#include "calib/panel/fit.h"
#include <Eigen/Core>

namespace panelcal {

/// A target that is to be measured: nothing is known of it but where the program puts it.
struct DesignTarget {
  Position<frame::Nominal> nominal;
  ObservedAxes axes = ObservedAxes::Both;
};

/// Covariance of [l00 l01 l10 l11 tx ty].
using MapCovariance = Eigen::Matrix<double, 6, 6>;

/// The part of the noise of targets that a fit hands on to holes; numbers of times, no unit.
///
/// The leverage of a place is the greatest standard deviation of the corrected place in any
/// direction, for targets that are measured with standard deviation 1 along each axis:
///
///   leverage(p)^2 = greatest eigenvalue of J(p) cov J(p)',   J(p) = [x y 0 0 1 0; 0 0 x y 0 1]
///
/// It is a norm of what is affine in p, hence convex: over any set of holes it is greatest at a
/// corner of their convex hull, and what lies below a level is convex.
class LeverageMap {
 public:
  explicit LeverageMap(const MapCovariance& cov);

  double operator()(const Position<frame::Nominal>& p) const;
  /// Of the corrected place; noise 1 along each axis.
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
  MapCovariance cov;      ///< of the whole map, for noise of 1 mm along each axis
  MapCovariance own_cov;  ///< without what a base correction leaves
  int degrees_of_freedom = 0;
};

struct PredictedFitResult {
  std::optional<PredictedFit> fit;
  FitFailure failure = FitFailure::TooFewTargets;
};

/// The covariance that fit_panel will find if every target has the same noise along both axes and
/// the panel is nearly the drawn one.
///
/// In     targets: where the program has them; base_cov: of the map under which they are looked up,
///        in units of this series' noise squared; zero for a base series
/// Out    cov: of the whole map; with a base it holds the part of its error that the nested fit
///        leaves
/// Fails  as fit_panel, on exactly the same designs
/// Cost   O(n)
/// See    tests/calib/advice/target_design_test.cc
PredictedFitResult predict_fit(std::span<const DesignTarget> targets,
                               PanelModel model,
                               const MapCovariance& base_cov = MapCovariance::Zero());

/// Power of the other targets to show an outlier.
struct LieDetection {
  enum class Answer : std::uint8_t { No, InPart, Yes };  ///< in part: for lies in some directions

  Answer is_found = Answer::No;  ///< its lie shows in the residuals
  Answer is_named = Answer::No;  ///< no other target's lie would leave the same residuals
  /// The smallest lie, in times the noise, that a test with 0.1 % false alarms finds in 80 % of all
  /// cases, in the direction where it shows least. Present if is_found is Yes.
  std::optional<double> found_from;
};

/// For each target of a design, whether its lie could be found and named.
///
/// With R = I - H, H what the fit makes of the measurements, a lie u of target i leaves the
/// residuals R(.,i) u: nothing is left in the directions where R(i,i) vanishes, and two targets can
/// be confused where the images of R(.,i) and R(.,j) meet, which their principal angles tell.
///
/// Source Baarda 1968 (reliability; 4.13 is the root of his noncentrality for 0.1 % and 80 %);
///        Bjorck and Golub 1973 (principal angles)
/// Cost   O(n^2)
std::vector<LieDetection> detect_lies(std::span<const DesignTarget> targets,
                                      const PredictedFit& fit);

/// The weakest of them all; nothing can be found without targets.
LieDetection weakest(std::span<const LieDetection> lies);

namespace internal {

/// Sums of J'J over targets: what they tell of the six coefficients, whatever the model.
MapCovariance information(const Eigen::Vector2d& p_mm, ObservedAxes axes);

/// As predict_fit from the sum of the targets' information; `ridge` keeps what they leave open
/// finite. Precondition: coordinates of the size of 1.
MapCovariance covariance_of(const MapCovariance& information,
                            PanelModel model,
                            const MapCovariance& base_cov,
                            double ridge);

}  // namespace internal
}  // namespace panelcal
