// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/correction/spindle_offsets.h"
#include "machine/config/settings/machine.h"

namespace panelcal {

/// Larger files are refused unread.
inline constexpr std::size_t kMaxConfigBytes = std::size_t{1} << 20;

/// Reads and validates machine.toml and the calibration files it names (relative to itself).
///
/// Fails  file-unreadable; toml-syntax; config-key-unknown; config-value; not-supported (keys that
///        are planned): each with line, column, the offending text and what was expected; what
///        calibration_file reports
/// See    tests/machine/config/machine_config_test.cc
Expected<MachineConfig> read_machine_config(const std::filesystem::path& file);

/// The same from text; `file` stands in the diagnostics, and calibration files are looked for
/// beside it.
Expected<MachineConfig> parse_machine_config(std::string_view text,
                                             const std::filesystem::path& file);

/// Takes another spindle of [spindle] calibration as the one that drills, as if machine.toml named
/// it. Where it is not calibrated, camera_offset_mm is the start value; without one the
/// present offset stays, which is another spindle's.
///
/// Fails  config-value (there is no such spindle or station)
Expected<void> select_spindle(MachineConfig& config, SpindleAt at);

/// Checks that holes may be placed with the offset.
///
/// Fails  config-value (it was never calibrated: see SpindleSetting::is_calibrated)
Expected<void> check_spindle_is_calibrated(const MachineConfig& config);

/// Lets the spindle-camera offset drift from its date to `now`, by the same clock as the date:
///
///   walk.uncertainty.drift_mm2 = drift^2 (now - date) I,   drift in mm per square root of a day
///
/// Until then, and without a date, the offset has not drifted.
/// Fails  config-value (the date is after now)
Expected<void> age_spindle_camera(MachineConfig& config, std::chrono::sys_seconds now);

}  // namespace panelcal
