// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal {

/// Displacement of the centre of a disc's picture from the picture of the disc's centre, to second
/// order in its radius.
///
/// Under a tilt the near half of a disc looks larger, under a bending lens the outer half larger or
/// smaller, and what a detector calls the centre moves there. With u(p) the map from panel to
/// picture, the centroid of the image of the disc |q| <= r about p is
///
///   int u(p + q) |du/dp(p + q)| dq / int |du/dp(p + q)| dq
///     = u(p) + r^2 / 4 (du/dp grad log |du/dp| + laplace u / 2) + O(r^4)
///
/// For a tilt alone it is the centre of the ellipse too. For a lens, a centre fitted to the rim is
/// that of another mean; the two differ by less than the fourth order says.
///
/// In     u: where the disc's centre is seen; sees(u)
/// Out    px, to be taken from what a detector measures
/// Source Heikkila 2000; Mallon and Whelan 2007; here from the map's own derivatives
/// See    tests/calib/camera/circle_bias_test.cc
Displacement<frame::Image> circle_bias(const CameraModel& camera,
                                       const Position<frame::Image>& u,
                                       Length radius);

}  // namespace panelcal
