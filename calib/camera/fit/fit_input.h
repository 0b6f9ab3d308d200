// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/camera/form.h"
#include <Eigen/Core>

namespace panelcal {

struct CameraObservation {
  std::size_t i_view = 0;
  std::size_t i_dot = 0;
  PositionEstimate<frame::Image> seen;
};

/// Pictures of a plate, or of one target at known stage places, at one zoom level.
struct CameraData {
  std::vector<PlateView> views;
  std::vector<PlateDot> dots;
  std::vector<CameraObservation> seen;
};

struct CameraFitOptions {
  CameraForm form = CameraForm::Flat;
  Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();  ///< as a rule the picture's middle
  /// Distance of the panel over the scale, from the lens' data sheet; infinite if telecentric.
  double focal_px = std::numeric_limits<double>::infinity();
  /// Start values if stage and plate leave them open; otherwise only the rotation is used, to begin
  /// with.
  double scale_mm_per_px = 0.01;
  double rotation_rad = 0;
  /// Residuals beyond this number of sigmas count by their length instead of its square (Huber); 0:
  /// none does. What is not noise hardly moves the result then, and honest noise costs it 5 %
  /// at 1.35.
  double huber_sigmas = 0;
  /// One in this number of observations is left out for the held-out check; 0: there is none.
  int held_out_every = 5;
};

}  // namespace panelcal
