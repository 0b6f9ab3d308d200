// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string_view>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/camera/mapping.h"
#include <Eigen/Core>

namespace panelcal {

/// The parameters of a camera model that a fit may free, in the order of its covariance.
enum class CameraParameter { Scale, Rotation, TiltX, TiltY, K1, K2, P1, P2 };
inline constexpr int kCameraParameters = 8;
std::string_view name(CameraParameter parameter);
std::string_view unit(CameraParameter parameter);

/// Covariance of [scale mm/px, rotation rad, tilt x 1, tilt y 1, k1 1/px^2, k2 1/px^4, p1 1/px,
/// p2 1/px].
using CameraModelCovariance = Eigen::Matrix<double, kCameraParameters, kCameraParameters>;
/// d place (mm) / d those parameters.
using CameraModelJacobian = Eigen::Matrix<double, 2, kCameraParameters>;

/// The map K from a picture to millimetres about the optical axis, for a camera that need not look
/// straight down and whose lens bends.
///
///   d  = u - axis
///   d' = d (1 + k1 |d|^2 + k2 |d|^4) + [2 p1 dx dy + p2 (|d|^2 + 2 dx^2)]
///                                      [p1 (|d|^2 + 2 dy^2) + 2 p2 dx dy]
///   w  = R(rotation) diag(1, -1) d'
///   K(u) = scale (w + q (q . w) / (1 + sqrt(1 + |q|^2))) / (1 - q . w / focal)
///
/// q, the tilt, is the tangent of the angle between the optical axis and the normal of the panel,
/// pointing in machine directions to where the panel is farther from the camera. The last line is
/// the central projection onto a plane so tilted, and `scale` that at the axis across the tilt.
///
/// Two numbers are given, not fitted. The axis: where it is said to be makes the zero of K, and a
/// lens whose center lies elsewhere shows the same picture with other p1, p2 and k1, to first order
/// (k1 |d - e|^2 (d - e) differs by k1 times the same vectors as p1, p2). The focal length, in px:
/// the distance of the panel over the scale; its error scales the tilt. Infinite for a telecentric
/// lens, which does not see a tilt but as a stretch.
///
/// With no tilt, k2, p1 and p2 it is CameraMapping.
///
/// Source Brown 1971 (lens, here in the undistorting direction); docs/conventions.md
/// See    tests/calib/camera/model_test.cc
class CameraModel {
 public:
  struct Parameters {
    double scale_mm_per_px = 0.01;
    double rotation_rad = 0;
    Eigen::Vector2d tilt = Eigen::Vector2d::Zero();
    double k1_per_px2 = 0;
    double k2_per_px4 = 0;
    double p1_per_px = 0;
    double p2_per_px = 0;
    Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();
    double focal_px = std::numeric_limits<double>::infinity();
  };

  /// Precondition: is_valid(parameters).
  explicit CameraModel(const Parameters& parameters);
  explicit CameraModel(const CameraMapping::Parameters& simple);

  /// Scale and focal length positive, everything but the focal length finite.
  static bool is_valid(const Parameters& parameters);

  const Parameters& parameters() const { return parameters_; }
  /// The simple form, if the model is no more than that.
  std::optional<CameraMapping::Parameters> as_mapping() const;

  /// Precondition: sees(u); elsewhere the panel is behind the horizon or the lens folds over.
  Position<frame::Optical> operator()(const Position<frame::Image>& u) const;
  /// dK/du, mm per px.
  Eigen::Matrix2d jacobian(const Position<frame::Image>& u) const;
  PositionEstimate<frame::Optical> operator()(const PositionEstimate<frame::Image>& u) const;
  CameraModelJacobian by_parameters(const Position<frame::Image>& u) const;
  /// True where K keeps its sense of rotation and the panel lies before the camera.
  bool sees(const Position<frame::Image>& u) const;

  /// The pixel that K carries to p, by Newton's method from the axis; empty if that leaves what the
  /// camera sees.
  std::optional<Position<frame::Image>> image_of(const Position<frame::Optical>& p) const;
  /// The same from a pixel that is near.
  std::optional<Position<frame::Image>> image_near(const Position<frame::Optical>& p,
                                                   const Position<frame::Image>& start) const;

 private:
  struct Ray;
  Ray ray(const Eigen::Vector2d& u_px) const;
  Eigen::Matrix2d straightening(const Eigen::Vector2d& d_px) const;

  Parameters parameters_;
  Eigen::Matrix2d turn_;  ///< R(rotation) diag(1, -1)
};

/// The covariance of the simple form: the model's, with an axis that is exact by definition.
CameraCovariance simple_covariance(const CameraModelCovariance& cov);

}  // namespace panelcal
