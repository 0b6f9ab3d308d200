// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/camera/fit/fit.h"
#include "calib/camera/full_camera.h"
#include "calib/camera/mapping.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal {

/// A camera calibration with all that makes it a record: when, from what, how well.
struct CameraCalibration {
  /// All there is to the camera, or what of `full` has this form: scale, rotation, axis, k1.
  CameraMapping::Parameters parameters;
  /// Of [scale mm/px, rotation rad, axis x px, axis y px, k1 1/px^2].
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  int picture_width_px = 0;
  int picture_height_px = 0;
  std::chrono::sys_seconds date{};
  std::string provenance;  ///< its origin, in the words of its maker
  /// Of files of version 2.
  std::optional<FullCamera> full;

  /// For searching and drawing. Where needs_model(), pixels become mm by model() only.
  CameraMapping mapping() const { return CameraMapping(parameters); }
  CameraModel model() const {
    return full ? CameraModel(full->parameters) : CameraModel(parameters);
  }
  /// True if the camera has a tilt or a lens that CameraMapping does not know.
  bool needs_model() const { return !model().as_mapping(); }
};

/// The calibration that holds a fitted camera; date and provenance are left to the caller.
CameraCalibration calibration_of(const FullCamera& camera, int width_px, int height_px);
FullCamera full_camera(const CameraFit& fit, const std::optional<double>& zoom);

/// Larger files are refused unread.
inline constexpr std::size_t kMaxCalibrationBytes = std::size_t{1} << 20;

/// Reads `*.cal.json` of kind "camera", version 1 or 2.
///
/// Strict: a number that is used to place holes is not guessed at. Unknown and missing keys, wrong
/// types, numbers outside their range, a covariance that is not positive semidefinite, and a lens
/// model that folds over inside the picture (1 + 3 k1 r^2 <= 0; version 2: a tilt or lens that does
/// not see the panel everywhere in the picture) are all refused.
///
/// Fails  file-unreadable; json-syntax (with line and column); calibration-invalid
/// See    tests/calib/camera/calibration/calibration_file_test.cc
Expected<CameraCalibration> read_camera_calibration(const std::filesystem::path& path);

/// The same from text; `file` is what diagnostics name. Any bytes give a value or a diagnostic.
Expected<CameraCalibration> parse_camera_calibration(std::string_view text,
                                                     const std::string& file);

/// The file's content, of version 2 if there is a full camera; numbers in the fewest digits that
/// read back exactly.
std::string camera_calibration_text(const CameraCalibration& calibration);

/// Writes the file whole or not at all; refuses what the reader would refuse.
///
/// Fails  calibration-invalid; device-write
Expected<void> write_camera_calibration(const std::filesystem::path& path,
                                        const CameraCalibration& calibration);

}  // namespace panelcal
