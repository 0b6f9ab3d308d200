// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/panel/model.h"
#include "calib/panel/target_pair.h"
#include <Eigen/Core>

namespace panelcal {

/// Reason why a fit is not possible.
enum class FitFailure {
  TooFewTargets,  ///< fewer equations than parameters
  Degenerate,     ///< coincident or collinear targets, or slots, leave the model open
  BadCovariance,  ///< a covariance is not positive definite, or a number is not finite
  Mirrored,       ///< left and right are exchanged (calib/panel/panel_fit.h)
  Folded,         ///< a smooth map turns a part of the panel over (likewise)
};

namespace internal {

struct RawFit {
  Eigen::Matrix2d linear;
  Eigen::Vector2d translation_mm;
  Eigen::Matrix<double, 6, 6> cov;                ///< of [l00 l01 l10 l11 tx ty]
  Eigen::Matrix<double, 6, Eigen::Dynamic> gain;  ///< d coefficients / d measured (x0 y0 x1 ..)
  std::vector<Eigen::Vector2d> residuals_mm;      ///< measured minus fitted; 0 if not observed
  double chi_square = 0;
  int degrees_of_freedom = 0;
};

/// Either a fit or why not.
struct RawFitResult {
  std::optional<RawFit> fit;
  FitFailure failure = FitFailure::TooFewTargets;
};

RawFitResult fit_raw(std::span<const RawPair> pairs, PanelModel model);

}  // namespace internal

template <class To, class From>
class SmoothPanelFit;

/// The fitted map with all that a report needs.
///
/// Of a panel that is bent smoothly (calib/panel/smooth_panel.h) `map` is the affine map nearest to
/// it at the targets; residuals and chi square are those of the bent one.
template <class To, class From>
struct PanelFit {
  PanelModel model = PanelModel::Offset;
  TransformEstimate<To, From> map;
  Eigen::Matrix<double, 6, Eigen::Dynamic> gain;
  std::vector<TargetPair<To, From>> pairs;
  std::vector<Displacement<To>> residuals;
  double chi_square = 0;
  int degrees_of_freedom = 0;
  /// The part of map.cov that comes from not knowing the model (calib/panel/model_choice.h).
  Eigen::Matrix<double, 6, 6> choice_cov = Eigen::Matrix<double, 6, 6>::Zero();
  /// The part of map.cov that comes from targets that do not agree (calib/panel/misfit.h).
  Eigen::Matrix<double, 6, 6> misfit_cov = Eigen::Matrix<double, 6, 6>::Zero();
  /// The correction in place of `map`; null: the panel is not bent.
  std::shared_ptr<const SmoothPanelFit<To, From>> smooth;
};

/// The fit or the reason why there is none.
template <class To, class From>
struct PanelFitResult {
  std::optional<PanelFit<To, From>> fit;
  FitFailure failure = FitFailure::TooFewTargets;
};

/// Fits the map of `model` that carries nominal targets onto measured ones.
///
///   measured_i = L nominal_i + t + e_i,   e_i ~ N(0, cov_i),   L as the model says
///
/// Weighted least squares: exact for offset, similarity and affine (linear in the coefficients),
/// Gauss-Newton on the model's own parameters for rigid and stretch, started at the linear
/// solution. Coordinates are centred and scaled first, so that conditioning does not depend on
/// where work zero lies.
///
/// Targets are degenerate by structure only: nearer than a nanometre, or on one line to a millionth
/// of its length. What noise makes nearly so is fitted, and its covariance says how badly. A
/// mirrored panel is no failure either: rigid and similarity rotate properly and leave residuals as
/// large as the panel, stretch and affine follow with a negative scale_y; the gates on residual and
/// on stretch refuse it.
///
/// A slot counts by the one coordinate it shows. The other and its variance may hold anything; its
/// residual and its gain are 0. With L = I + [a b; c d] a target's two equations are
///
///   x a + y b + tx = measured x - x        x c + y d + ty = measured y - y
///
/// where the model couples a to d (b = -c = -theta, and so on). Slots determine the model if their
/// equations have full rank in its parameters near L = I, to a millionth. So every model needs an
/// x and a y; a rotation two y at different x, or two x at different y; a scale of x two x at
/// different x. Of several rotations that slots leave open the fit takes the one near zero, unless
/// another fits beyond doubt better.
///
/// The gain is the derivative of the estimate itself, with the model's curvature. Where residuals
/// are as large as the distances between the targets it is Gauss-Newton's, without the curvature.
///
/// In     pairs: nominal and measured mm, covariance mm^2; a slot's only in its axis
/// Out    map with the 6x6 covariance of its coefficients; gain; residuals mm; chi square, d.o.f.
///        by scalar equations
/// Fails  TooFewTargets; Degenerate; BadCovariance
/// Cost   O(n); allocates the results only
/// Source CNC-7 manual, Vision Assist, G36; Umeyama 1991 (rigid start); Bjorck 1996 (covariance)
/// See    tests/calib/panel/fit_test.cc, tests/calib/panel/slots/fit_slots_test.cc
template <class To, class From>
PanelFitResult<To, From> fit_panel(std::span<const TargetPair<To, From>> pairs, PanelModel model) {
  internal::RawFitResult result = internal::fit_raw(internal::raw_pairs(pairs), model);
  if (!result.fit) return {std::nullopt, result.failure};

  PanelFit<To, From> fit;
  fit.model = model;
  fit.map = {Transform<To, From>(result.fit->linear, result.fit->translation_mm), result.fit->cov};
  fit.gain = std::move(result.fit->gain);
  fit.pairs.assign(pairs.begin(), pairs.end());
  for (const auto& residual_mm : result.fit->residuals_mm) {
    fit.residuals.push_back(displacement_mm<To>(residual_mm));
  }
  fit.chi_square = result.fit->chi_square;
  fit.degrees_of_freedom = result.fit->degrees_of_freedom;
  return {std::move(fit), FitFailure::TooFewTargets};
}

}  // namespace panelcal
