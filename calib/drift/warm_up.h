// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// A value measured a time after the machine was started.
struct WarmUpSample {
  Time since_start;
  Eigen::VectorXd value;  ///< one number an axis, in a unit of the caller's
  double sigma = 0;       ///< of each axis, above 0
};

/// Course of a machine's warm-up.
struct WarmUp {
  bool is_seen = false;  ///< false: warm and cold do not differ as far as the samples tell
  Time time_constant;
  Time time_constant_sigma;
  Eigen::VectorXd warm;         ///< values at the end
  Eigen::VectorXd cold_offset;  ///< cold minus warm
  Time wait;                    ///< until less than the limit is left; 0 if that never is more
  Time wait_sigma;
};

/// Fits value(t) = warm + cold_offset exp(-t / time_constant), and says how long to wait until the
/// rest of it is below `limit` (in the values' unit, all axes together).
///
/// In     samples: 6 times or more of one warm-up, any order
/// Out    empty: `reason` says why: too few or broken samples, samples that scatter more than they
///        say, or that end before the machine is warm to the limit
/// See    tests/calib/drift/warm_up_test.cc
std::optional<WarmUp> fit_warm_up(std::span<const WarmUpSample> samples,
                                  double limit,
                                  std::string* reason);

}  // namespace panelcal
