// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include "surface/fit/bending/bending_kernel.h"
#include <Eigen/Core>

// Not installed: part of surface/fit/fit.h.
namespace panelcal::internal {

/// Probed heights as numbers that keep their digits: about their centre and mean, places in units
/// of half the diagonal of their rectangle.
struct Readings {
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();
  double scale_mm = 1;
  double mean_mm = 0;
  Eigen::Matrix2Xd places;
  Eigen::VectorXd heights_mm;
  Eigen::VectorXd sigmas_mm;
  bool is_scatter_stated = true;  ///< of all of them; else how much they scatter is learned
};

/// The trend over the whole panel: (1, x, y) or, with bow and twist, (1, x, y, x^2, x y, y^2).
using Trend = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;
Trend trend_at(const Eigen::Vector2d& place, Eigen::Index n_trend);

/// Bending that explains the readings, in units of Readings.
struct Bending {
  BendingKernel kernel = BendingKernel::None;
  double length = 1;
  double strength_mm2 = 0;  ///< by the noise factor's square
  double noise_factor = 1;  ///< scatter of the readings by what they say
  double minus_2_log_likelihood = std::numeric_limits<double>::infinity();
};

/// The restricted likelihood of readings of a bent surface.
///
///   height_i = trend_i beta + f_i + e_i,   e_i ~ N(0, k^2 sigma_i^2),   f ~ N(0, k^2 s C(length))
///
/// In contrasts that no trend can change, z ~ N(0, k^2 (1 + s B)). With B made tridiagonal once for
/// a length, each strength s costs O(n); k is known in closed form. Of k it is believed beforehand,
/// with the weight of kPriorReadings readings, that it is 1: few readings cannot say how much they
/// scatter.
///
/// Source Patterson and Thompson 1971 (restricted likelihood); Gu and Wahba 1991 (tridiagonal)
class BendingLikelihood {
 public:
  static constexpr double kPriorReadings = 10;

  /// Empty if the readings do not determine the trend: a plane but for rounding, bow and twist
  /// clearly, by more than how little the probes stand off two rows.
  static std::optional<BendingLikelihood> of(const Readings& readings, Eigen::Index n_trend);

  Eigen::Index n_readings() const { return weights_per_mm_.size(); }
  Eigen::Index n_contrasts() const { return contrasts_.cols(); }
  /// Places that readings have, those within 1 % of half the diagonal of each other counted as one:
  /// what readings of one place differ in is scatter, and no bending.
  Eigen::Index n_places() const { return n_places_; }
  /// True if there are more places than the trend has coefficients: others show no bending at all.
  bool has_seen_bending() const { return n_places_ > trend_root_.rows(); }
  /// Q2 of W trend = Q1 R, W = diag(1 / sigma)
  const Eigen::MatrixXd& contrasts() const { return contrasts_; }
  /// R^-1 Q1^T W: the trend that least squares find.
  const Eigen::MatrixXd& trend_of_heights() const { return trend_of_heights_; }
  /// R^-1
  const Eigen::MatrixXd& trend_root() const { return trend_root_; }

  /// The lengths to try, falling by a factor from the size of the panel.
  ///
  /// In     shortest_by_spacing: the shortest by the readings' mean spacing
  std::vector<double> lengths(double factor, double shortest_by_spacing) const;
  /// True if the stated scatter explains what the readings miss of the trend by itself: by chance
  /// more than one in 1000 of straight surfaces would miss as much.
  bool is_trend_enough() const;
  /// The likeliest noise factor of the trend by itself, stated scatter or not.
  double noise_factor_of_trend() const;
  /// Covariance of the readings' bendings for strength 1.
  Eigen::MatrixXd covariance(BendingKernel kernel, double length) const;
  /// Q2^T W C W Q2, by the few reflections that Q is made of: O(n^2).
  Eigen::MatrixXd contrast_covariance(const Eigen::MatrixXd& covariance) const;

  /// The likeliest one, of contrasts whose squares by what is believed of them sum up to this.
  double noise_factor(double chi_square) const;
  /// The best strength for a kernel and a length, perhaps 0; 0 without has_seen_bending().
  Bending best_strength(BendingKernel kernel, double length) const;
  /// The mean strength for a kernel and a length, its minus_2_log_likelihood that of all strengths
  /// together.
  ///
  /// Before, any mean variance of the contrasts' bendings from 1/100 of their scatter to 100 times
  /// their mean square is as likely on a logarithmic scale. The mean of the strength, rather than
  /// the best, holds as a variance: how much a board bends that few readings have seen is not
  /// known. Without has_seen_bending() it is 0: no prior tells what no contrast depends on.
  ///
  /// In     share: of the likelihood that counts, see kEvidenceShare of
  /// surface/fit/bending/bending_average.h
  Bending mean_strength(BendingKernel kernel, double length, double share) const;
  /// The best kernel and length as well, between the readings' spacing and the size of the panel.
  Bending best_of(std::span<const BendingKernel> kernels) const;

 private:
  BendingLikelihood() = default;
  Bending refined(std::span<const Bending> tried) const;
  struct Tridiagonal;
  Tridiagonal tridiagonal(BendingKernel kernel, double length) const;

  Eigen::MatrixXd distances_;  ///< of places, within 1e-4 of each other one; only the lower half
  Eigen::VectorXd weights_per_mm_;  ///< 1 / sigma
  OrthogonalTriangular qr_;         ///< of W trend
  Eigen::MatrixXd contrasts_;
  Eigen::MatrixXd trend_root_;
  Eigen::MatrixXd trend_of_heights_;
  Eigen::VectorXd z_;  ///< Q2^T W height
  Eigen::Index n_places_ = 0;
  bool is_scatter_stated_ = true;
};

}  // namespace panelcal::internal
