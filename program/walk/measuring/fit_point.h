// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/panel/target_pair.h"

namespace panelcal {

/// A target as a fit sees it: one measurement, or the mean of several. The covariance is the
/// picture's and what the machine adds to every target; measurements keep the picture's alone, so
/// that a recorded run replays with any machine's figures.
struct FitPoint {
  Position<frame::Nominal> nominal;
  PositionEstimate<frame::Actual> measured;
  ObservedAxes axes = ObservedAxes::Both;
  CameraJacobian by_camera = CameraJacobian::Zero();
  int i_camera = 0;               ///< as MachineUncertainty counts
  int n_arrivals = 1;             ///< of the stage, of which `measured` is the mean
  std::size_t i_measurement = 0;  ///< the one to name when the point is at fault
};

}  // namespace panelcal
