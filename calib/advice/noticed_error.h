// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calib/advice/target_design.h"
#include "calib/base/units.h"
#include "calib/panel/gates.h"
#include <Eigen/Core>

namespace panelcal {

/// The gate that is the first to notice an error of a target as it grows.
enum class NoticingGate : std::uint8_t { None, FalseAlarm, Residual, Rotation, Stretch, Offset };

/// "chi square", "residual", "rotation", "stretch", "offset"; "none".
std::string_view name(NoticingGate gate);

/// The size of an error of one target from which on a job is held.
struct NoticedError {
  /// In units of the series' noise, in the direction where the error shows least: an error as large
  /// is noticed in kNoticedShare of all cases, or more. Absent: in some direction no gate looks.
  std::optional<double> from;
  NoticingGate by = NoticingGate::None;  ///< in that direction
  /// The direction in which it shows least, a unit vector; of a slot along its axis.
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
};

inline constexpr double kNoticedShare = 0.8;

/// For each target of a design, the smallest error of it alone that the gates in force notice.
///
/// An error u of target i moves the coefficients by G_i u and leaves residuals; chi square becomes
/// non-central:
///
///   G_i = cov J_i' W_i,   noncentrality = u' (W_i - W_i J_i cov J_i' W_i) u,   W_i = cov_i^-1
///
/// The test of chi square notices u by its exact distribution. A limit on a residual, a rotation, a
/// stretch or the offset notices what moves its number beyond it along the line in which u moves
/// it, for a panel that lies as drawn; the other numbers can only add to that. Of several gates the
/// best counts, so that the share noticed is at least the one stated, and larger by what a second
/// gate notices alone.
///
/// In     fit: of these targets; noise: the unit of the fit's covariance; limits: of the series,
///        with its own share of the false alarms
/// Out    one per target
/// Cost   O(n^2), some 40 directions each
/// Source Baarda 1968 (reliability); docs/formulation.md
/// See    tests/calib/advice/noticed_error_test.cc
std::vector<NoticedError> noticed_errors(std::span<const DesignTarget> targets,
                                         const PredictedFit& fit,
                                         Length noise,
                                         const GateLimits& limits);

/// The index of the target whose error is noticed latest; one that is never noticed comes first.
/// Precondition: not empty.
std::size_t least_noticed(std::span<const NoticedError> errors);

}  // namespace panelcal
