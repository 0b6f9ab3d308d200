// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/camera_mapping.h"

namespace panelcal {

/// A camera calibration with all that makes it a record: when, from what, how well.
struct CameraCalibration {
  CameraMapping::Parameters parameters;
  /// Of [scale mm/px, rotation rad, axis x px, axis y px, k1 1/px^2].
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  int picture_width_px = 0;
  int picture_height_px = 0;
  std::chrono::sys_seconds date{};
  std::string provenance;  ///< what it was made from, in the words of who made it

  CameraMapping mapping() const { return CameraMapping(parameters); }
};

/// Larger files are refused unread.
inline constexpr std::size_t kMaxCalibrationBytes = std::size_t{1} << 20;

/// Reads `*.cal.json` of kind "camera", version 1.
///
/// Strict: a number that is used to place holes is not guessed at. Unknown and missing keys, wrong
/// types, numbers outside their range, a covariance that is none, and a lens model that folds over
/// inside the picture (1 + 3 k1 r^2 <= 0) are all refused.
///
/// Fails  file-unreadable; json-syntax (with line and column); calibration-invalid
/// See    tests/calib/calibration_file_test.cc
Expected<CameraCalibration> read_camera_calibration(const std::filesystem::path& path);

/// The same from text; `file` is what diagnostics name. Any bytes give a value or a diagnostic.
Expected<CameraCalibration> parse_camera_calibration(std::string_view text,
                                                     const std::string& file);

/// The file's content; numbers in the fewest digits that read back exactly.
std::string camera_calibration_text(const CameraCalibration& calibration);

/// Writes the file whole or not at all; refuses what the reader would refuse.
///
/// Fails  calibration-invalid; device-write
Expected<void> write_camera_calibration(const std::filesystem::path& path,
                                        const CameraCalibration& calibration);

}  // namespace panelcal
