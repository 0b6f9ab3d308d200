// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "machine/calibrate/calibration.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_job.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// A machine calibrates itself at night, without a person.
///
/// Lock, ledger, repair of an installation that was interrupted, warm-up, self-test; then each
/// calibration is measured, judged (decide_night and the charts of scatter), appended to the ledger
/// with its verdict, and only then its file written from the ledger. So whenever a night is cut
/// off, the ledger says which file should be there, and the next run puts it there; what this
/// night's ledger already has is not measured again. What cannot be judged is not installed.
///
/// One run a machine: <ledger>.lock, which the system frees however a run ends.
/// A damaged ledger is kept aside and a new one begun; nothing is installed from then on until a
/// person marks a fresh start (night_history.h). A dry run moves nothing and writes nothing.
///
/// Fails  config-value (no [ledger] file; what a calibration needs is missing): exit 2;
///        ledger-busy (another run), ledger-cut-off (it lacks entries that calibrations and reports
///        note: nothing moves), what the ledger reports: exit 3. What fails later is in the record.
/// See    tests/machine/nightly
Expected<NightRecord> run_nightly(const NightJob& job);

/// The same with calibrations of the caller's, in their order, instead of [nightly] calibrate.
Expected<NightRecord> run_nightly(const NightJob& job, std::span<Calibration* const> calibrations);

/// The night that a time belongs to, "2026-11-21": from noon to noon, by the day it begins on.
std::string night_of(std::chrono::sys_seconds time, int noon_utc_h);

}  // namespace panelcal
