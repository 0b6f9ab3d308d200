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
#include "calib/base/machine_uncertainty.h"
#include <Eigen/Core>

namespace panelcal {

/// What a panel may have done between the drawing and the table, from stiff to soft.
enum class PanelModel {
  Offset,      ///< tx ty
  Rigid,       ///< theta tx ty
  Similarity,  ///< theta s tx ty
  Stretch,     ///< theta sx sy tx ty: R(theta) diag(sx, sy) p + t
  Affine,      ///< six free coefficients
};

int parameter_count(PanelModel model);
std::string_view name(PanelModel model);
std::optional<PanelModel> panel_model_from_name(std::string_view name);

/// The model the manual prescribes for a series of n points: 1 offset, 2 offset and rotation,
/// 3 or more offset, rotation and stretch (CNC-7 manual, Vision Assist, G36).
PanelModel default_model(int n_points);

/// The same by scalar equations, of which a point gives two and a slot one: below 3 offset, below
/// 6 rigid, or similarity if a scale is wanted and there are 4; from 6 on stretch (SIEB & MEYER
/// G31, measurement mode 5).
PanelModel default_model_of_equations(int n_equations, bool with_scale);

/// An affine map in the words of the trade: map = R(rotation) [scale_x, shear; 0, scale_y].
///
/// scale_x is never negative; a mirrored map has a negative scale_y.
struct PanelDeformation {
  double rotation_rad = 0;
  double scale_x = 1;
  double scale_y = 1;
  double shear = 0;
};
PanelDeformation deformation_of(const Eigen::Matrix2d& linear);

/// The coordinates that a measurement determines: both of a hole, one of a slot (SIEB & MEYER G32
/// and G33 in measurement mode 5).
enum class ObservedAxes : std::uint8_t { Both, X, Y };

constexpr bool observes_x(ObservedAxes axes) {
  return axes != ObservedAxes::Y;
}

constexpr bool observes_y(ObservedAxes axes) {
  return axes != ObservedAxes::X;
}

/// A target: where the program says, where it was seen, and how well that is known.
template <class To, class From>
struct TargetPair {
  Position<From> nominal;
  PositionEstimate<To> measured;  ///< of which only `axes` count
  ObservedAxes axes = ObservedAxes::Both;
  /// Not seen by the fit: what `measured` shares with other targets, see CorrectionStack.
  CameraJacobian by_camera = CameraJacobian::Zero();
  int i_camera = 0;    ///< whose calibration that is, as MachineUncertainty counts
  int n_arrivals = 1;  ///< of the stage, of which `measured` is the mean
};

/// Why a fit is not possible.
enum class FitFailure {
  TooFewTargets,  ///< fewer equations than parameters
  Degenerate,     ///< coincident or collinear targets, or slots, leave the model open
  BadCovariance,  ///< a covariance is not positive definite, or a number is not finite
};

namespace internal {

struct RawPair {
  Eigen::Vector2d from_mm;
  Eigen::Vector2d to_mm;
  Eigen::Matrix2d cov_mm2;
  ObservedAxes axes = ObservedAxes::Both;
};

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

template <class To, class From>
std::vector<RawPair> raw_pairs(std::span<const TargetPair<To, From>> pairs) {
  std::vector<RawPair> raw;
  raw.reserve(pairs.size());
  for (const auto& pair : pairs) {
    raw.push_back(
        {pair.nominal.in_mm(), pair.measured.position.in_mm(), pair.measured.cov, pair.axes});
  }
  return raw;
}

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
  /// What corrects instead of `map`; null: the panel is not bent.
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
/// See    tests/calib/panel/fit_test.cc, tests/calib/panel/fit_slots_test.cc
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
