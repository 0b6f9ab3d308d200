// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/correction/spindle_offsets.h"

namespace panelcal {

/// Circumstances of the fit of an offset, for comparing nights. Nothing is computed with it.
struct SpindleQuality {
  int n_holes = 0;     ///< that the offset is made of
  int n_looks = 0;     ///< at them
  int n_left_out = 0;  ///< holes
  /// Between holes; both together where `repeatability_um` is absent.
  std::array<double, 2> wander_um = {};
  std::optional<std::array<double, 2>> repeatability_um;  ///< between looks at one hole
  std::array<std::optional<double>, 2> backlash_um = {};  ///< x, y; absent: not determined

  friend bool operator==(const SpindleQuality&, const SpindleQuality&) = default;
};

/// Offset of one spindle with its date and quality.
struct SpindleOffsetRecord {
  std::chrono::sys_seconds date{};
  std::optional<SpindleQuality> quality;
};

/// The calibrated spindles of a machine, with all that makes them a record.
struct SpindleCalibration {
  SpindleOffsets offsets;
  std::chrono::sys_seconds date{};  ///< UTC: when the newest of them was found
  std::string provenance;           ///< from what, in the words of who found it
  /// Of the same spindles as `offsets`; one that is not there has `date` and no quality.
  std::map<SpindleAt, SpindleOffsetRecord> records = {};

  std::chrono::sys_seconds date_of(SpindleAt at) const;
};

/// Reads `*.cal.json` of kind "spindle-camera", version 1.
///
/// Strict, as read_camera_calibration is: unknown and missing keys, wrong types, a spindle that is
/// there twice, offsets beyond 100 m and what is no covariance are refused.
///
/// Fails  file-unreadable; json-syntax (with line and column); calibration-invalid
/// See    docs/formats/calibration.md; tests/calib/spindle/calibration_file_test.cc
Expected<SpindleCalibration> read_spindle_calibration(const std::filesystem::path& path);

/// The same from text; `file` is what diagnostics name. Any bytes give a value or a diagnostic.
Expected<SpindleCalibration> parse_spindle_calibration(std::string_view text,
                                                       const std::string& file);

/// The file's content; numbers in the fewest digits that read back exactly.
std::string spindle_calibration_text(const SpindleCalibration& calibration);

/// Writes the file whole or not at all; refuses what the reader would refuse.
///
/// Fails  calibration-invalid; device-write
Expected<void> write_spindle_calibration(const std::filesystem::path& path,
                                         const SpindleCalibration& calibration);

}  // namespace panelcal
