// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include "vision/fit/target.h"
#include "vision/render/scene.h"

namespace panelcal {

/// Pose and appearance of one mark on the board.
struct MarkLook {
  Position<frame::Optical> center;
  Angle turn;  ///< on top of the target's own angle, the same way round
  /// Brightness, 0 to 1 of full scale: of a tag what is white in its family. Templates have their
  /// own, in the target's polarity.
  double level = 0.7;
  double ground = 0.3;                       ///< its surroundings: of a tag the black of its family
  Length slot_length = mm(20);               ///< from end to end, for slots
  Displacement<frame::Optical> hole_offset;  ///< of a ring's hole
  Roughness burrs;                           ///< of holes
};

/// The features that show a target to a camera.
///
/// In     target: valid; mapping: the camera's, as calibrated: it says where the axes of a target
///        in px lie, and how large its px are
/// Out    painted in this order, the target is where and as large as it says; a ring whose hole is
///        not given has one of half its diameter, a tag that may be any is number 0
/// See    tests/vision/render/scene_marks_test.cc
std::vector<Feature> mark_features(const Target& target,
                                   const MarkLook& look,
                                   const CameraMapping& mapping);

/// No place of the features is farther from a place than this.
Length reach_of(const std::vector<Feature>& features, const Position<frame::Optical>& from);

}  // namespace panelcal
