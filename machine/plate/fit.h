// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/units.h"
#include <Eigen/Core>

// Not installed: a part of looking at plates.
namespace panelcal::internal {

/// A place on the plate, and where on the machine it was seen.
struct PlacePair {
  Eigen::Vector2d plate_mm;
  Eigen::Vector2d machine_mm;
};

/// The rigid motion that carries the places on the plate onto those on the machine best.
///
/// In     least_lever: places whose distances from their middle make less (root of the sum of their
///        squares) say nothing of the angle, which stays that of `pose`
/// Out    `pose` where there are no pairs
PlatePose best_pose(const std::vector<PlacePair>& pairs, const PlatePose& pose, Length least_lever);

/// Distance of places from those of a pose, rms; 0 of none.
Length rms_from(const PlatePose& pose, const std::vector<PlacePair>& pairs);

}  // namespace panelcal::internal
