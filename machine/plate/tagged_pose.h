// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "machine/config/plate/plate.h"

// Not installed: a part of looking at plates.
namespace panelcal::internal {

/// A tag as a picture shows it, through the camera's calibration and from where the axis stood.
struct TagSight {
  std::size_t i_picture = 0;
  int id = 0;
  std::array<Position<frame::Machine>, 4> corners;  ///< in the order of corners_of()
};

/// Pose of a plate, and the pictures that contradict it.
struct TaggedPose {
  struct Contradiction {
    std::size_t i_picture = 0;  ///< each once
    std::string why;
  };

  PlatePose pose;
  std::vector<Contradiction> contradictions;
  std::vector<std::size_t> agreeing;  ///< pictures with tags, all as the pose has them; each once
};

/// Finds how a plate lay while pictures of it were taken, from the tags that they show.
///
/// Every tag alone says how the plate lay. The one that most others agree with is taken, and fitted
/// to all that agree: to a quarter of the pitch, and to an eighth of a turn. Neither a tag that is
/// misread nor one that lies elsewhere can so shift the lattice by a pitch unseen in the pictures
/// that show a tag; of others nothing is said. A tag that the plate does not have contradicts if it
/// lies on it. More than one tag in four that contradicts says that the plate's file or the stage
/// is wrong.
///
/// Of one tag alone its code has to differ from others' in nine bits or more.
///
/// In     plate: with tags; sights: of tags of the plate's size, in pictures of one pose
/// Fails  calibration-data (no tag of the plate; tags that contradict one another; one tag alone
///        that is easily misread), without a place
/// Cost   O(n^2) for n sights that contradict one another, O(n) where they agree
/// See    tests/machine/plate/tagged_pose_test.cc
Expected<TaggedPose> pose_from_tags(const CalibrationPlate& plate,
                                    const std::vector<TagSight>& sights);

}  // namespace panelcal::internal
