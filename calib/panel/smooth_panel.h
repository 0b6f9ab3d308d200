// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/panel/fit.h"
#include <Eigen/Core>

namespace panelcal {

/// A bending is not looked for with fewer targets, and not with more: its cost grows with the cube
/// of their number.
inline constexpr int kLeastSmoothTargets = 6;
inline constexpr int kMostSmoothTargets = 128;

namespace internal {

using SmoothBasis = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostSmoothTargets + 3, 1>;

/// A covariance that changes from place to place, mm^2: [b^T xx b, b^T xy b; b^T xy b, b^T yy b]
/// with b(p) of RawSmooth. All three are symmetric.
struct CovarianceForm {
  Eigen::MatrixXd xx, xy, yy;

  /// Of the weights of b, x and y by turns.
  static CovarianceForm of_weights(const Eigen::MatrixXd& cov);
  void operator+=(const CovarianceForm& other);
  Eigen::Matrix2d operator()(const SmoothBasis& b) const;
};

/// The fitted bending, ready for a million holes. In b(p) = (phi_1 .. phi_n, 1, x, y), with x, y
/// and the distances in phi from the centre in units of the scale,
///
///   f(p) = weights b(p)            cov f(p) = cov(b(p))
///
/// and, with the smoothing as it is, f(p) answers to measured_i by sum_k b_k(p) by_measured_ki.
struct RawSmooth {
  using Basis = SmoothBasis;

  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_center_mm = Eigen::Vector2d::Zero();
  double scale_mm = 1;
  Eigen::Matrix2Xd knots;    ///< the targets' nominal places, scaled
  Eigen::Matrix2Xd weights;  ///< mm, 2 x (n + 3)
  CovarianceForm cov;
  CovarianceForm choice;        ///< the part of cov that comes from having chosen this model
  CovarianceForm misfit;        ///< the part of cov that comes from targets that do not agree
  Eigen::MatrixXd by_measured;  ///< 2 (n + 3) x 2 n: d weights / d measured, x and y by turns
  std::vector<Eigen::Vector2d> residuals_mm;  ///< measured minus fitted; 0 if not observed
  double chi_square = 0;
  double parameters = 0;  ///< effective
  std::optional<double> left_out_rms_mm;
  /// False where the weights are an affine map's, and only its covariance counts that the panel may
  /// be bent (calib/panel/model_choice.h).
  bool is_bent = true;

  double criterion() const { return chi_square + 2 * parameters; }
  Basis basis(const Eigen::Vector2d& p) const;  ///< of a scaled place
  Basis basis_at(const Eigen::Vector2d& p_mm) const { return basis((p_mm - center_mm) / scale_mm); }
  /// d f / d measured of one target.
  Eigen::Matrix2d by_target(const Basis& b, std::size_t i_target) const;
  /// The whole weights of an affine map, as if it were fitted.
  Eigen::Matrix2Xd weights_of(const Eigen::Matrix2d& linear,
                              const Eigen::Vector2d& translation_mm) const;
  /// f(p), written out: a product with that many columns would allocate.
  Eigen::Vector2d place_mm(const Basis& b) const;
  Eigen::Vector2d map_mm(const Eigen::Vector2d& p_mm) const;
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& p_mm) const;
  Eigen::Matrix2d cov_mm2(const Eigen::Vector2d& p_mm) const;
};

std::optional<RawSmooth> fit_smooth_raw(std::span<const RawPair> pairs);

/// True if the map keeps every piece of the panel the right way round: the jacobian's determinant
/// is positive all over the targets' rectangle and a quarter of its sides around it, by sampling.
bool is_unfolded(const RawSmooth& smooth, std::span<const RawPair> pairs);

}  // namespace internal

/// A panel that is bent smoothly on top of an affine map.
template <class To, class From>
class SmoothPanelFit {
 public:
  explicit SmoothPanelFit(internal::RawSmooth raw) : raw_(std::move(raw)) {}

  Position<To> map(const Position<From>& p) const {
    return position_mm<To>(raw_.map_mm(p.in_mm()));
  }
  /// d map / d p.
  Eigen::Matrix2d jacobian(const Position<From>& p) const { return raw_.jacobian(p.in_mm()); }
  /// Of map(p), mm^2; it counts that nothing was measured between the targets.
  Eigen::Matrix2d covariance(const Position<From>& p) const { return raw_.cov_mm2(p.in_mm()); }

  double chi_square() const { return raw_.chi_square; }
  double parameters() const { return raw_.parameters; }  ///< effective number
  double criterion() const { return raw_.criterion(); }  ///< as compare_models
  std::optional<double> left_out_rms_mm() const { return raw_.left_out_rms_mm; }
  const std::vector<Eigen::Vector2d>& residuals_mm() const { return raw_.residuals_mm; }
  bool is_bent() const { return raw_.is_bent; }
  const internal::RawSmooth& raw() const { return raw_; }

 private:
  internal::RawSmooth raw_;
};

/// Fits an affine map and a thin-plate spline on top of it to six targets or more.
///
///   measured_i = A nominal_i + t + f(nominal_i) + e_i,   e_i ~ N(0, cov_i)
///
/// f bends each coordinate of the panel like a thin plate: as a Gaussian process it has, up to
/// affine maps, the covariance s r^2 log r, the same for x and y. Its strength s is not known. For
/// every s the estimate is the smoothing spline with that smoothing; all of them are averaged with
/// the weights that the data give them, restricted likelihood times the prior of smoothing.h. So an
/// affine panel is hardly bent, and no covariance takes an estimated smoothing for the true one: it
/// grows until 95 % ellipses hold 95 % of what the strengths allow (growth_to_95_percent).
///
/// The effective number of parameters is the trace of d fitted / d measured, whitened, with the
/// answer of the weights to the data: chi square + 2 parameters is then unbiased for the error of
/// predicting the same targets again (Stein 1981), as for the models without a bending.
/// Leave-one-out is exact for the weights as they are.
///
/// In     pairs: nominal and measured mm, covariance mm^2; slots in their axis only
/// Out    nothing below kLeastSmoothTargets or above kMostSmoothTargets, or where the targets do
///        not determine an affine map
/// Cost   O(n^3) once; a hole O(n) and its covariance O(n^2), neither allocates
/// Source Duchon 1977; Wahba 1983, 1990 (1.5, 4.5); Bookstein 1989; Polson and Scott 2012;
///        docs/formulation.md
/// See    tests/calib/panel/smooth_panel_test.cc
template <class To, class From>
std::optional<SmoothPanelFit<To, From>> fit_smooth_panel(
    std::span<const TargetPair<To, From>> pairs) {
  std::optional<internal::RawSmooth> raw = internal::fit_smooth_raw(internal::raw_pairs(pairs));
  if (!raw) return std::nullopt;
  return SmoothPanelFit<To, From>(*std::move(raw));
}

/// An affine fit with the bending of the same targets on top.
template <class To, class From>
PanelFitResult<To, From> with_bending(PanelFit<To, From> affine, SmoothPanelFit<To, From> smooth) {
  const internal::RawSmooth& raw = smooth.raw();
  const double n_equations = affine.degrees_of_freedom + parameter_count(PanelModel::Affine);
  affine.chi_square = raw.chi_square;
  affine.degrees_of_freedom =
      static_cast<int>(std::lround(std::max(0.0, n_equations - raw.parameters)));
  affine.residuals.clear();
  for (const Eigen::Vector2d& residual_mm : raw.residuals_mm) {
    affine.residuals.push_back(displacement_mm<To>(residual_mm));
  }
  affine.smooth = std::make_shared<const SmoothPanelFit<To, From>>(std::move(smooth));
  return {std::move(affine), FitFailure::TooFewTargets};
}

/// The same as a fit that corrects holes, with its affine part: that is the affine fit to the
/// targets, for the residuals of a spline are orthogonal to affine maps.
///
/// Degrees of freedom are the equations less the effective parameters, to the nearest number: chi
/// square has this expectation, and spreads less than one of that number of degrees.
///
/// Out    TooFewTargets also where there are too many targets or too few equations
template <class To, class From>
PanelFitResult<To, From> fit_bent(std::span<const TargetPair<To, From>> pairs) {
  PanelFitResult<To, From> result = fit_panel(pairs, PanelModel::Affine);
  if (!result.fit) return result;
  std::optional<SmoothPanelFit<To, From>> smooth = fit_smooth_panel(pairs);
  if (!smooth) return {};
  return with_bending(*std::move(result.fit), *std::move(smooth));
}

}  // namespace panelcal
