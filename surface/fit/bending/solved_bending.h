// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "surface/fit/bending/bending_likelihood.h"
#include <Eigen/Core>

// Not installed: part of surface/fit/fit.h.
namespace panelcal::internal {

/// Places in units of Readings, with their trends and covariances for every bending.
class RelatedPlaces {
 public:
  RelatedPlaces(const Readings& readings, const Eigen::Matrix2Xd& places, Eigen::Index n_trend);

  /// trend_at(), a column for each place.
  const Eigen::MatrixXd& trends() const { return trends_; }
  /// bending_covariance() of the distances from the readings (rows) to the places. Of a kernel
  /// whose length is halved the exponentials are powers of those before: ask for long ones first.
  Eigen::MatrixXd covariances(BendingKernel kernel, double length);

 private:
  struct Falloff {
    BendingKernel kernel;
    double length;
    Eigen::ArrayXXd values;  ///< exp of the kernel's exponent
  };
  const Eigen::ArrayXXd& falloff(BendingKernel kernel, double length);

  Eigen::ArrayXXd distances_;
  Eigen::MatrixXd trends_;
  std::vector<Falloff> falloffs_;
};

/// A reading as the others predict it: not at all if the trend needs it.
struct LeftOutReading {
  bool is_predicted = false;
  double deviation_mm = 0;
  double sigma_mm = 0;  ///< its own scatter included
};

/// Heights and variances of a surface of one bending.
///
/// In units of Readings. With F^T F = P = W Q2 (1 + s B)^-1 Q2^T W and G the trend by the heights,
/// in c(p) the covariances of a place with the readings and t(p) its trend,
///
///   height = t beta + s c^T P y             beta = G (y - s C P y)
///   variance / k^2 = s (c(p, p) - 2 c^T g + g^T C g) + |R^-T t|^2 - s^2 |F (c - C g)|^2
///   with g = G^T t
///
/// The bending is first predicted from the trend's own readings, then from the contrasts, which
/// know nothing of the trend.
///
/// See    tests/surface/fit/fit_test.cc
class SolvedBending {
 public:
  enum class Noise { Given, Learned };

  /// In     noise: whether the noise factor is the bending's or the likeliest of these readings
  /// Cost   O(n^3)
  SolvedBending(const Bending& bending,
                const Readings& readings,
                const BendingLikelihood& likelihood,
                Noise noise);

  double length() const { return bending_.length; }
  double noise_factor() const { return bending_.noise_factor; }
  /// In the order of the readings; a reading left out is missed by [P y]_i / P_ii, of variance
  /// k^2 / P_ii.
  const std::vector<LeftOutReading>& left_out() const { return left_out_; }

  /// Heights about the readings' mean, mm. O(n) each.
  Eigen::VectorXd heights_mm(RelatedPlaces& places) const;
  /// Heights and variances of the surface. O(n^2) each.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> at(RelatedPlaces& places) const;
  /// Covariance of the surface's error from place to place.
  Eigen::MatrixXd covariance_mm2(RelatedPlaces& places, const Eigen::Matrix2Xd& reduced) const;

 private:
  void leave_out(const Eigen::VectorXd& sigmas_mm,
                 const Eigen::MatrixXd& root,
                 const Eigen::VectorXd& residual_weights);

  Bending bending_;
  Eigen::VectorXd trend_mm_;       ///< beta
  Eigen::VectorXd weights_;        ///< s P y
  Eigen::MatrixXd onto_;           ///< [s F; G], times c
  Eigen::MatrixXd root_of_trend_;  ///< s F C G^T
  Eigen::MatrixXd trend_bending_;  ///< G C G^T
  Eigen::MatrixXd trend_root_;     ///< R^-1
  std::vector<LeftOutReading> left_out_;
};

}  // namespace panelcal::internal
