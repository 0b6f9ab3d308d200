// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

struct WarmUpRun {
  Time waited;
  std::optional<NightWarmUp> seen;  ///< with a limit
};

/// Moves the stage to and fro for as long as [nightly] says, between the quarters of its travel, or
/// where that is not known about the coupon.
///
/// With [nightly] warm_up_limit_um the mark is looked at again and again meanwhile, and it ends as
/// soon as the looks tell that less than the limit is still to come. Each time there are three
/// looks, whose scatter says how sure they are (calib/drift/rest_to_come.h).
///
/// In     clock: ends it sooner where moving itself takes long; one that stands still does no harm
/// Fails  device-stage; device-frame; config-value (neither [machine] travel nor [coupon]; a limit
///        without a mark or a clock of the devices); as MarkLooker
/// See    tests/machine/nightly/checks/warm_up_test.cc; calib/drift/warm_up.h
Expected<WarmUpRun> warm_up(const MachineConfig& config,
                            const NightlyConfig& nightly,
                            const CalibrationDevices& devices,
                            const Clock& clock);

/// Says in `seen` whether the machine is warm: whether less than the limit may still be to come, of
/// looks that follow an exponential. Pure.
void judge_warm_up(NightWarmUp& seen);

/// The same for the self-test's table.
SelfTestCheck warm_up_check(const NightWarmUp& seen);

/// Warm-up of the newest night that has measured it: "night of 2026-11-21: warm after ...". Empty
/// where none has.
///
/// Fails  what the ledger reports
Expected<std::string> last_warm_up(const Ledger& ledger, const std::string& machine);

/// An object of JSON: `limit_mm`, `warm`, `text`, `looks` of [seconds, x mm, y mm, sigma mm], and
/// `fit`, or null.
std::string warm_up_json(const NightWarmUp& seen);

}  // namespace panelcal
