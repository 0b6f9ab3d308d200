// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "calib/base/diagnostic.h"
#include "machine/check/stated_keys.h"
#include "machine/config/machine_config.h"
#include "program/walk/survey.h"
#include "program/walk/walk.h"

namespace panelcal {

/// Holds machine.toml as a whole against itself, before anything moves: what a night or a job would
/// come upon only when it is there.
///
///   [coupon]            every row that it promises, with the ways to it, drilled and looked at, is
///                       within travel; its vision tool is defined (with [camera])
///   [nightly] mark_mm   the mark can be seen within travel; its vision tool is defined
///   [nightly] calibrate everything that each calibration needs is there; the rectangle of
///                       [nightly.surface] and the dots of the plate are within travel
///   keys together       as check_vision_rules(), check_coupon_rules() and check_file_rules() say
///   [ledger], [nightly] the ledger has every entry that calibrations and reports note
///   [nightly.drift]     the calibrations in force are not older than trusted_days (a warning)
///
/// Nothing is driven, and no file is written; the coupon's state, the plate's file, the
/// ledger and the reports are read.
///
/// In     keys: those of config.file
/// Out    log: every problem, each where machine.toml has its cause
/// See    tests/golden/config/day-0-machine.case and its kin
void check_machine(const MachineConfig& config,
                   const StatedKeys& keys,
                   std::chrono::sys_seconds now,
                   DiagnosticLog& log);

/// Holds what a program asks the camera for against machine.toml: vision tools that are not
/// defined, once each, and the first target that cannot be looked at within travel. Of a machine
/// without a [camera], whose measurements come from elsewhere, nothing is asked.
///
/// In     nominal: the survey of the perfect panel
/// Out    log: errors, in the program's lines
void check_targets(const MachineConfig& config,
                   const Program& program,
                   const Survey& nominal,
                   DiagnosticLog& log);

}  // namespace panelcal
