// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// The map K from a picture to millimetres about the optical axis, in machine directions.
///
///   d = u - axis,   K(u) = scale R(rotation) diag(1, -1) d (1 + k1 |d|^2)
///
/// diag(1, -1) because y points down in a picture and up on the machine. One radial term is enough
/// for the narrow view of a machine camera (Brown 1971; here in the undistorting direction, so that
/// the measured side of the map is closed and only the drawing side iterates).
class CameraMapping {
 public:
  struct Parameters {
    double scale_mm_per_px = 0.01;
    double rotation_rad = 0;
    /// Point at which the optical axis meets the picture.
    Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();
    double k1_per_px2 = 0;
  };

  /// Precondition: scale > 0, all finite (calibration_file refuses others).
  explicit CameraMapping(const Parameters& parameters);

  const Parameters& parameters() const { return parameters_; }

  Position<frame::Optical> operator()(const Position<frame::Image>& u) const;
  /// dK/du, mm per px.
  Eigen::Matrix2d jacobian(const Position<frame::Image>& u) const;
  PositionEstimate<frame::Optical> operator()(const PositionEstimate<frame::Image>& u) const;
  /// dK/d parameters at a pixel: what an error of the calibration moves, the same for all pictures.
  ///
  ///   dK/d scale = K / scale    dK/d rotation = K turned by 90 degrees    dK/d axis = -dK/du
  ///   dK/d k1 = scale R(rotation) diag(1, -1) d |d|^2
  CameraJacobian by_parameters(const Position<frame::Image>& u) const;

  /// The pixel that K carries to p, by Newton's method; empty where the lens model folds over
  /// (1 + 3 k1 r^2 <= 0), which is far outside any calibrated picture.
  std::optional<Position<frame::Image>> image_of(const Position<frame::Optical>& p) const;

 private:
  Parameters parameters_;
  Eigen::Matrix2d mm_from_px_;
};

}  // namespace panelcal
