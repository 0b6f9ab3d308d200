// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/night_gates.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// Quality of tonight's measurements, against the nights before.
struct QualityVerdict {
  std::vector<NightQuality> qualities;
  std::vector<NightGate> gates;     ///< refused ones: what tonight measured is not to be trusted
  std::vector<std::string> alarms;  ///< all, the slow ones too
};

/// Holds scatter and levels against those of the nights before.
///
/// Scatters go through a SpreadMonitor each. Levels (contrast, blur) are judged by their logarithm
/// with a DriftMonitor each: where they jump to the bad side the night is refused. What grows
/// slowly, or jumps to the good side, is said and refuses nothing. Each of them by itself alarms
/// falsely once in WatchOptions::nights_per_false_alarm, and half of that refuses. Levels are
/// judged after DriftOptions::min_nights.
///
/// In     nights: with ascending times; tonight: after them
/// Fails  calibration-invalid: a number that is not finite
/// See    tests/machine/nightly/night_quality_test.cc
Expected<QualityVerdict> judge_qualities(std::span<const QualityNight> nights,
                                         const QualityNight& tonight,
                                         const NightlyConfig& config);

}  // namespace panelcal
