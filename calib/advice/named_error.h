// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "calib/advice/target_design.h"
#include "calib/base/units.h"
#include "calib/panel/gates.h"
#include <Eigen/Core>

namespace panelcal {

/// A series of which one target is off, and what a job holds it against.
struct ErrorTrial {
  std::span<const DesignTarget> targets;
  PanelModel model = PanelModel::Offset;
  Length noise;              ///< the unit of the targets' covariances
  GateLimits limits;         ///< of the series, with its own share of the false alarms
  std::size_t i_target = 0;  ///< that is off
  Eigen::Vector2d error = Eigen::Vector2d::Zero();  ///< in units of the noise
};

/// The answers of a job to it, in trials that differ by the noise.
struct ErrorTrials {
  int n = 0;
  int n_noticed = 0;   ///< the series is held
  int n_named = 0;     ///< and the target that is off is named as the outlier
  int n_misnamed = 0;  ///< and another target is

  double noticed_share() const { return n > 0 ? static_cast<double>(n_noticed) / n : 0; }
  double named_share() const { return n > 0 ? static_cast<double>(n_named) / n : 0; }
};

/// Draws the noise of a series with an error, fits it, holds it against the gates and asks
/// find_fault for the outlier, as a job does. Which target is named follows no formula: the causes
/// that find_fault weighs compete with each other.
///
/// The panel lies as drawn, all pictures are equally good but for their stated noise, and no pad
/// lies where the error takes the target; a job that knows of such a pad names it as the cause.
///
/// Out    the same for the same seed, on every machine
/// Fails  targets that do not determine the model are never noticed
/// Cost   a trial some 1 ms for 4 targets, 10 ms for 24
/// See    tests/calib/advice/named_error_test.cc
ErrorTrials try_error(const ErrorTrial& trial, int n_trials, std::uint64_t seed);

}  // namespace panelcal
