// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

namespace frame {
struct Plate {};  ///< a calibration plate's own, as its drawing or certificate has it, mm
struct Table {};  ///< true place of the stage, about machine zero, machine directions, mm
}  // namespace frame

/// A dot of a calibration plate, or the one target that is looked at from many places.
struct PlateDot {
  Position<frame::Plate> place;  ///< as certified; otherwise only where to begin
  bool is_certified = true;      ///< otherwise its place is estimated along with everything else
  Length radius;                 ///< 0: so small that it is seen where its centre is
};

/// The pose of a plate: machine = R(angle) plate + shift.
struct PlatePose {
  double angle_rad = 0;
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();
};

/// The place of the optical axis and the pose of the plate when a picture was taken.
struct PlateView {
  Position<frame::Machine> axis_at;  ///< commanded
  std::size_t i_pose = 0;            ///< views of one pose see the plate in the same place
};

}  // namespace panelcal
