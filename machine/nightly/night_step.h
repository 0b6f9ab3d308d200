// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/night_job.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// The common data of the steps of one night.
struct NightContext {
  const NightJob& job;
  /// [nightly], with what each chart has of the rate of false alarms that is stated for all.
  const NightlyConfig& nightly;
  std::string night;
  std::optional<double> temperature_c;
  /// The reason to measure nothing (the self-test did not pass); empty: measure. The one in force
  /// may stay if the forecast lets it.
  std::string no_measuring;
  /// The reason not to install the result; empty: its gates decide.
  std::string untrusted = {};
};

/// Makes one calibration of a night, from the history to the written file. Whatever fails is in the
/// step.
NightStep run_night_step(const NightContext& context, Calibration& calibration, Ledger& ledger);

/// The same without moving or writing anything: what there is, and what would be done.
///
/// In     ledger: nullptr where there is none yet
NightStep foresee_night_step(const NightContext& context, Calibration& calibration, Ledger* ledger);

/// One that is not begun because another has failed.
NightStep unreached_night_step(const Calibration& calibration, const std::string& why);
/// One that is not begun because a person has to see to something first.
NightStep held_night_step(const Calibration& calibration, const std::string& why);

}  // namespace panelcal
