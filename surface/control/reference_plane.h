// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// A height above the table plane and one standard deviation of its error.
struct HeightEstimate {
  Length height;
  Length sigma;
};

/// A place that was probed and what was found there.
struct ProbedHeight {
  Position<frame::Machine> position;
  HeightEstimate measured;
};

struct ReferencePlaneResult;

/// z = z0 + a x + b y, fitted to probed heights.
///
/// Kept about the probes' weighted centroid, where height and slopes are uncorrelated; so a plane
/// far from machine zero loses no digits.
class ReferencePlane {
 public:
  /// The plane's height at p, with the uncertainty of the fit; p is taken as exact.
  HeightEstimate height_at(const Position<frame::Machine>& p) const;

  /// dz/dx and dz/dy.
  const Eigen::Vector2d& slope() const { return slope_; }
  const Eigen::Matrix2d& slope_covariance() const { return slope_cov_; }
  /// Measured minus fitted, in the order of the probes.
  std::span<const Length> residuals() const { return residuals_; }
  double chi_square() const { return chi_square_; }
  int degrees_of_freedom() const { return static_cast<int>(residuals_.size()) - 3; }

 private:
  friend ReferencePlaneResult fit_reference_plane(std::span<const ProbedHeight> probes);
  explicit ReferencePlane(std::span<const ProbedHeight> probes);

  Eigen::Vector2d center_mm_ = Eigen::Vector2d::Zero();
  double height_mm_ = 0;
  double height_variance_mm2_ = 0;
  Eigen::Vector2d slope_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slope_cov_ = Eigen::Matrix2d::Zero();
  std::vector<Length> residuals_;
  double chi_square_ = 0;
};

/// The reason why no plane could be fitted.
enum class PlaneFailure {
  TooFewProbes,  ///< fewer than three
  Collinear,     ///< coincident probes, or probes in one line
  BadSigma,      ///< a sigma is not above 0, or a number is not finite
};

/// The plane or why there is none.
struct ReferencePlaneResult {
  std::optional<ReferencePlane> plane;
  PlaneFailure failure = PlaneFailure::TooFewProbes;
};

/// Fits the plane by least squares, each probe weighted by its sigma.
///
///   height_i = z0 + a x_i + b y_i + e_i,   e_i ~ N(0, sigma_i^2)
///
/// In     probes: n >= 3; position in Machine, mm; height and sigma mm
/// Out    plane with the covariance the sigmas imply (not scaled by the residuals); residuals
/// Fails  TooFewProbes; Collinear (spread across below a millionth of the spread along); BadSigma
/// Cost   O(n)
/// Source SIEB & MEYER CNC 8x.00, surface detection; Bjorck 1996 (covariance)
/// See    tests/surface/control/reference_plane_test.cc
ReferencePlaneResult fit_reference_plane(std::span<const ProbedHeight> probes);

}  // namespace panelcal
