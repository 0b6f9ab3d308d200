// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "panelcal/calib/base/estimate.h"
#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/panel_fit.h"

namespace panelcal {

/// A bending is not looked for with fewer targets, and not with more: its cost grows with the cube
/// of their number.
inline constexpr int kLeastSmoothTargets = 6;
inline constexpr int kMostSmoothTargets = 128;

namespace internal {

/// The fitted bending, ready for a million holes. In b(p) = (phi_1 .. phi_n, 1, x, y), with x, y
/// and the distances in phi from the centre in units of the scale,
///
///   f(p) = weights^T b(p)            cov f(p) = [b^T xx b, b^T xy b; b^T xy^T b, b^T yy b]
struct RawSmooth {
  using Basis = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostSmoothTargets + 3, 1>;

  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_center_mm = Eigen::Vector2d::Zero();
  double scale_mm = 1;
  Eigen::Matrix2Xd knots;    ///< the targets' nominal places, scaled
  Eigen::Matrix2Xd weights;  ///< mm, 2 x (n + 3)
  Eigen::MatrixXd xx, xy, yy;
  std::vector<Eigen::Vector2d> residuals_mm;  ///< measured minus fitted; 0 if not observed
  double chi_square = 0;
  double parameters = 0;  ///< effective
  std::optional<double> left_out_rms_mm;

  double criterion() const { return chi_square + 2 * parameters; }
  Basis basis(const Eigen::Vector2d& p) const;  ///< of a scaled place
  Eigen::Vector2d map_mm(const Eigen::Vector2d& p_mm) const;
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& p_mm) const;
  Eigen::Matrix2d cov_mm2(const Eigen::Vector2d& p_mm) const;
};

std::optional<RawSmooth> fit_smooth_raw(std::span<const RawPair> pairs);

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
/// the weights that the data give them, restricted likelihood times a prior that is uniform in the
/// share of the data a spline takes up. So a panel that is affine is hardly bent, and there is
/// neither a threshold nor a covariance that takes an estimated smoothing for the true one.
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
/// Source Duchon 1977; Wahba 1983, 1990 (1.5, 4.5); Bookstein 1989; Daniels 1999 (prior);
///        docs/formulation.md
/// See    tests/calib/smooth_panel_test.cc
template <class To, class From>
std::optional<SmoothPanelFit<To, From>> fit_smooth_panel(
    std::span<const TargetPair<To, From>> pairs) {
  std::optional<internal::RawSmooth> raw = internal::fit_smooth_raw(internal::raw_pairs(pairs));
  if (!raw) return std::nullopt;
  return SmoothPanelFit<To, From>(*std::move(raw));
}

}  // namespace panelcal
