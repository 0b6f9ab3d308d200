// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "machine/check/stated_keys.h"
#include "machine/config/settings/machine.h"

namespace panelcal {

/// Holds [coupon] and what nights do beside it against each other:
///
///   pitch_mm                   larger than the hole that the vision tool describes
///   [nightly.gates] min_holes  at most the columns * rows_per_run holes of a night
///   [nightly] mark_mm          outside of the coupon's rows, which are drilled
///   [nightly.surface]          its rectangle does not cover rows of the coupon
///
/// Out    log: config-value, at the key of each
/// See    tests/machine/check/coupon_rules_test.cc
void check_coupon_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log);

}  // namespace panelcal
