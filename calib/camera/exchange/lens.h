// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include <Eigen/Core>

namespace panelcal {

/// The program that a file of a camera model belongs to.
enum class LensFormat : std::uint8_t {
  OpenCvYaml,        ///< `camera_matrix` and `distortion_coefficients` of OpenCV's FileStorage
  RosCameraInfo,     ///< `camera_info` as YAML: of ROS' camera_calibration, or as a message
  MrcalCameraModel,  ///< mrcal's `.cameramodel`
};

/// `opencv`, `ros` or `mrcal`, as options name them.
std::string_view name_of(LensFormat format);

/// A pinhole with Brown's lens, as other programs have it: from the ray to the pixel.
///
///   x = X/Z, y = Y/Z, r^2 = x^2 + y^2
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
///   u = fx x' + cx,  v = fy y' + cy
///
/// Pixel (0, 0) is the center of the top-left pixel, x right, y down, as in docs/conventions.md.
///
/// Source OpenCV, calib3d (plumb bob); ROS sensor_msgs/CameraInfo; mrcal LENSMODEL_OPENCV5
struct Lens {
  LensFormat format = LensFormat::OpenCvYaml;
  int width_px = 0;
  int height_px = 0;
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();  ///< fx, fy
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool is_bent() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }
};

/// Larger files are refused unread: mrcal's may hold what they were calibrated from.
inline constexpr std::size_t kMaxLensBytes = std::size_t{1} << 26;

/// Reads a camera model of another program; its text tells whose it is.
///
/// Fails  measurement-file, with line and column: a file of none of them; a key that is missing,
///        twice there or has another value than it takes; a model that Lens is not (a fisheye, a
///        rational or a thin prism model, splines), by its name
/// See    tests/calib/camera/exchange/lens_test.cc
Expected<Lens> parse_lens(std::string_view text, const std::string& file);

/// The text of a file in lens.format. `comment` is one line.
///
/// mrcal's has no extrinsics: the identity.
std::string lens_text(const Lens& lens, std::string_view comment);

}  // namespace panelcal
