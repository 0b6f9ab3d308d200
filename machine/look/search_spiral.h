// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/look/picture_locator.h"
#include <Eigen/Core>

namespace panelcal {

/// The part of a view in which a target's middle may lie so that the picture has all of it: a
/// rectangle along the picture's sides, machine directions.
struct UsableView {
  Eigen::Vector2d middle_mm;  ///< from the optical axis
  Eigen::Vector2d along_mm;   ///< from side to side of the rectangle
  Eigen::Vector2d across_mm;  ///< the same, at right angles
};

/// The rectangle that is left if `margin` is taken from every side of a picture: half of what
/// neighbouring views of a search overlap by.
///
/// Fails  not-supported (a picture smaller than that)
Expected<UsableView> usable_view(const ZoomedCamera& camera, Length margin);

/// Places of the optical axis, one after the other, so that the usable parts of the views cover a
/// disc about `expected` without a gap.
///
/// A lattice of the usable rectangles, walked from the middle outwards in a square spiral, so that
/// every step but those over left-out corners leads to a neighbour; rectangles that do not touch
/// the disc are left out. The first place is `expected` itself.
///
/// Fails  not-supported (more than 400 views)
/// See    tests/machine/look/search_spiral_test.cc
Expected<std::vector<Position<frame::Machine>>> search_spiral(
    const Position<frame::Machine>& expected, Length radius, const UsableView& view);

}  // namespace panelcal
