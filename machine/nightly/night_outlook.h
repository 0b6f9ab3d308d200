// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/night_gates.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// Tonight's own place in a history.
struct NightPlace {
  DriftPoint point;           ///< left out if refused, or if nothing was found
  bool is_in_series = false;  ///< the history has it already: an earlier run of this night
};

/// Puts into a step what the nights together say of it: what was predicted, the alarms, since when
/// something has changed, the plot's points, and how long what is in force may be used.
///
/// In     history: as it was before tonight's entry, or with it (NightPlace::is_in_series)
///        in_force: after tonight; absent if nothing is
/// Fails  calibration-invalid: [nightly.drift]
Expected<void> fill_outlook(const NightHistory& history,
                            const NightPlace& tonight,
                            const std::optional<Eigen::VectorXd>& in_force,
                            const NightlyConfig& config,
                            NightStep& step);

/// The nights as the outlook's charts learn them, where a step counts as a fresh start.
/// decide_night has the same model then as the forecast that is shown.
///
/// Fails  calibration-invalid: [nightly.drift]
Expected<DriftSeries> series_as_learned(const NightHistory& history, const NightlyConfig& config);

}  // namespace panelcal
