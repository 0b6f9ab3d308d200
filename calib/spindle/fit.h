// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/base/units.h"
#include "calib/correction/spindle_camera.h"
#include "calib/spindle/coupon.h"
#include <Eigen/Core>

namespace panelcal {

struct SpindleCameraFitOptions {
  /// Chance that a sound coupon loses a hole, above 0 and at most 0.5. Larger: holes that drilled
  /// badly are found sooner, but to lose a sound one makes the offset look better than it is.
  double outlier_false_alarm = 0.002;
  /// At most this number of holes is left out; more are a failure. Absent: a quarter. Never so
  /// many that fewer than five are left: of six holes one, of five none.
  std::optional<int> max_outliers = std::nullopt;
  /// The bound of the stage's backlash, as a standard deviation: needed where all
  /// looks came from another side than the drill. Zero: the stage has none.
  std::optional<Length> backlash = std::nullopt;
  /// The scatter that machine.toml states; if both are there the residuals are held against them.
  std::optional<Length> expected_wander = std::nullopt;         ///< between holes
  std::optional<Length> expected_repeatability = std::nullopt;  ///< between looks at one hole
  /// A trend is called significant at this chance of a false one; above 0 and at most 0.5.
  double significance = 0.01;
};

enum class SpindleCameraFailure {
  BadOptions,       ///< an option is outside its bounds
  BadInput,         ///< a hole without looks, a number that is not finite, a bad covariance
  TooFewHoles,      ///< fewer than kLeastHoles, or too few for what scatters
  BacklashUnknown,  ///< looks came from another side than the drill, and always from the same
  TooManyOutliers,  ///< more holes do not fit than may be left out
};

/// The failure in words, for people.
std::string text(SpindleCameraFailure failure);

/// With two holes the scatter has two degrees of freedom, and no variance at all.
inline constexpr int kLeastHoles = 3;

/// One standard deviation along x and y that was estimated; equal unless the axes differ.
struct ScatterEstimate {
  std::array<Length, 2> sigma;
  /// Its own standard error. Where sigma is zero: how large it might be.
  std::array<Length, 2> error;
  /// The interval that holds the true one in 95 of 100 coupons. Estimated variances are skew: sigma
  /// +- 1.96 `error` would hold it in 91, and always miss it on the same side.
  ///
  ///   high^2 = M nu / chi2(nu, 0.025) - r,   M = sigma^2 + r,   nu = 2 M^2 / var(M)
  ///
  /// with r the variance that is known otherwise to be in M (detector; of means also the scatter
  /// between looks); low alike, and 0 where that is negative. Source Satterthwaite 1946
  std::array<Length, 2> low;
  std::array<Length, 2> high;
};

/// Twice the distance of the stage's stops from its command, along one axis:
/// it stops at command - backlash / 2 when it moves up, and at command + backlash / 2 moving down.
struct BacklashEstimate {
  bool is_determined = false;  ///< looks and drill came from several sides against each other
  Length value;
  Length sigma;
};

struct CouponHoleResidual {
  /// Of the hole from where the fit has it: where the drill went astray.
  Displacement<frame::Machine> residual;
  /// Of a sound hole's residual, about zero.
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();
  bool is_outlier = false;
  /// Chance that a sound hole lies so far out; only of holes that were tested as suspects.
  std::optional<double> chance;
};

/// A turn, counter-clockwise, and growth of what was seen against what should have been, by a
/// linear regression of the residuals.
struct ResidualTrend {
  double rotation_rad = 0;
  double rotation_sigma_rad = 0;
  double scale_ppm = 0;
  double scale_sigma_ppm = 0;
  double chance = 1;  ///< of such a trend where there is none (F test)
  bool is_significant = false;
};

/// Result of the fit of the offset, with all that a report needs.
struct SpindleCameraFit {
  /// With the covariance for all that follows: right in the mean although it was estimated.
  SpindleCameraOffset offset;
  /// Of the variance of each coordinate; infinite if only the detector's noise was seen.
  Eigen::Vector2d degrees_of_freedom = Eigen::Vector2d::Zero();
  /// d offset / d camera parameters. The offset is right for the camera calibration that it was
  /// found with: an error of its axis is in both, and cancels where both are used together.
  CameraJacobian by_camera = CameraJacobian::Zero();

  /// False if (nearly) every hole was looked at once: then `wander` is both together.
  bool is_separated = false;
  bool has_unequal_axes = false;             ///< x and y scatter differently, and were fitted apart
  ScatterEstimate wander;                    ///< between holes: the drill, the stage when drilling
  ScatterEstimate repeatability;             ///< between looks, without the detector's own noise
  std::array<BacklashEstimate, 2> backlash;  ///< x, y

  std::vector<CouponHoleResidual> holes;  ///< in the order of the input
  int n_used = 0;                         ///< holes
  int n_views = 0;                        ///< looks at them
  double chi_square = 0;                  ///< of the used looks against the fitted scatter
  int n_free = 0;                         ///< its degrees of freedom
  /// Chance of so much scatter if machine.toml is right; absent if it does not say.
  std::optional<double> chance_as_expected;

  /// Over the coupon: it turned or grew between drilling and looking. Absent: not determined.
  std::optional<ResidualTrend> over_coupon;
  /// Over the picture: the camera's calibration is turned or has another scale. Absent: holes were
  /// always seen at the same place.
  std::optional<ResidualTrend> over_picture;

  /// This number of further holes, looked at as often, would halve the standard deviation.
  int more_holes_to_halve = 0;
  /// This number of further looks at each hole would; absent if no number of them could, or that is
  /// not known.
  std::optional<int> more_views_to_halve;

  int n_outliers() const { return static_cast<int>(holes.size()) - n_used; }
  /// One line.
  std::string summary() const;
  /// All of it, in lines.
  std::string report() const;
};

struct SpindleCameraFitResult {
  std::optional<SpindleCameraFit> fit;
  SpindleCameraFailure failure = SpindleCameraFailure::TooFewHoles;
};

/// Fits the spindle-camera offset to looks at holes that the spindle drilled.
///
///   drilled_i - spindle_iv - seen_iv = d + B (a_i - a_iv) / 2 + w_i + r_iv + e_iv
///
/// d the offset (calib/correction/spindle_camera.h), B = diag of the backlashes, a the approaches
/// of drilling and looking, w drill wander, r repeatability of the stage, e the detector's noise,
/// whose covariance is known. Backlash is fitted along an axis where a_i - a_iv varies; where it
/// does not vary and is not zero, d is only as good as SpindleCameraFitOptions::backlash and
/// without that refused. Wander and repeatability are variance components by restricted likelihood,
/// one value for both axes unless a likelihood ratio says that they differ; d comes by generalised
/// least squares, its covariance enlarged by nu / (nu - 2) for variances that are themselves
/// estimates.
///
/// Outliers are whole holes. Holes are ordered by their distance from a Huber location (2.5
/// sigma) of all. From the farthest on, each is held against a fit of those nearer than it by
///
///   T^2 / 2 ~ F(2, nu),   with 1 / n of the false alarms for each of the n holes left
///
/// and the last one that fails, with all beyond it, is left out (Rosner's many-outlier rule, which
/// keeps several outliers from hiding each other). Nothing else is dropped or weighted down.
///
/// A shift of the coupon between drilling and looking is in d and cannot be told from it; its turn
/// can, and is tested for. A scale of the table's axes moves nothing, drill and camera using the
/// same.
///
/// In     holes: 3 or more; all drilled with one spindle and looked at in one clamping
/// Fails  see SpindleCameraFailure
/// Cost   some 10 ms for 9 holes with 4 looks; linear in holes, cubic in looks at each
/// Source CNC-7 manual, Vision System Autocalibration, G39; SIEB & MEYER G39,SPOP; Searle, Casella
///        and McCulloch 1992; Patterson and Thompson 1971 (REML); Huber 1964; Rosner 1983
/// See    tests/calib/spindle/fit_test.cc
SpindleCameraFitResult fit_spindle_camera(std::span<const CouponHole> holes,
                                          const SpindleCameraFitOptions& options = {});

}  // namespace panelcal
