// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "calib/base/diagnostic.h"
#include "machine/config/machine_config.h"

namespace panelcal {

/// Warns of the calibrations in force that a night makes anew and whose age is beyond
/// [nightly.drift] trusted_days: nights that no longer run, or that install nothing, leave them
/// there.
///
/// Looks at the camera (each zoom level), the spindle-camera offset and the table; what states no
/// date, and machines without [nightly], have no limit.
///
/// In     now: a date that is stated by hand is by the clock on the wall, so that an age is known
/// to
///        some hours
/// Out    log: warnings, at [nightly] of machine.toml
/// See    tests/machine/check/calibration_ages_test.cc
void check_calibration_ages(const MachineConfig& config,
                            std::chrono::sys_seconds now,
                            DiagnosticLog& log);

}  // namespace panelcal
