// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

// Effect of a normal error of mean zero on the distance |e| of a hole from its place. A covariance
// is symmetric, mm^2; it may be singular, and eigenvalues that rounding made negative count as
// zero.

/// Standard deviations along the principal axes of a covariance.
struct PrincipalSigmas {
  Length large;
  Length small;
};
PrincipalSigmas principal_sigmas(const Eigen::Matrix2d& cov_mm2);

/// The probability that |e| is larger than `radius`.
///
///   P = 1/pi int_0^pi exp(-radius^2 / (2 q(t))) dt,   q(t) = s1^2 cos^2 t + s2^2 sin^2 t,
///
/// with s1, s2 the principal standard deviations: in coordinates that make e circular its length is
/// Rayleigh's and its direction t is uniform. Without s2 this is Craig's form of the error
/// function. The integrand is periodic and smooth, so that the trapezoidal rule converges
/// exponentially.
///
/// Out    0 to 1, to 1e-6 of itself; 0 where the bound exp(-radius^2 / (2 s1^2)) is below 1e-20,
/// for
///        errors are not normal so far out; 1 where the covariance is not finite, since then the
///        place of the hole is unknown
/// Cost   17 exponentials where radius is 3 to 8 times the larger sigma; up to 1000 error functions
///        where it is a small part of it
/// Source Hoyt 1947 (distribution of |e|); Craig 1991 (the integral's form); Trefethen and Weideman
///        2014 (convergence)
/// See    tests/calib/correction/breaking_probability_test.cc
double breaking_probability(const Eigen::Matrix2d& cov_mm2, Length radius);

/// The mean of |e|: sqrt(2/pi) s1 E(sqrt(1 - (s2/s1)^2)), E the complete elliptic integral of the
/// second kind. The mean of |e|^2 is the covariance's trace.
///
/// Source Abramowitz and Stegun 17.6 (by the arithmetic-geometric mean)
Length mean_radial_error(const PrincipalSigmas& sigmas);

/// The radius that |e| exceeds with this probability, 0 < probability < 1: 0.05 for the radius that
/// holds 95 %.
Length radius_exceeded(const PrincipalSigmas& sigmas, double probability);

/// breaking_probability of places of which many that follow each other have the same covariance.
class BreakingRisk {
 public:
  double operator()(const Eigen::Matrix2d& cov_mm2, Length radius) {
    if (cov_mm2(0, 0) != xx_ || cov_mm2(0, 1) != xy_ || cov_mm2(1, 1) != yy_ || radius != radius_) {
      xx_ = cov_mm2(0, 0);
      xy_ = cov_mm2(0, 1);
      yy_ = cov_mm2(1, 1);
      radius_ = radius;
      risk_ = breaking_probability(cov_mm2, radius);
    }
    return risk_;
  }

 private:
  double xx_ = 0;
  double xy_ = 0;
  double yy_ = 0;
  Length radius_;
  double risk_ = 0;  ///< of an exact place
};

}  // namespace panelcal
