// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include "vision/fit/detection.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal {

/// Finds a target and fits it to sub-pixel accuracy.
///
/// A coarse search sees every candidate: radial voting for round targets, correlation with the
/// target's own picture for others, the AprilTag library for tags. Each is fitted by maximum
/// likelihood to the pixels around it, with an edge model behind a Gaussian lens and square pixels:
///
///   I(u) = light(u) (level + contrast share((K(u) - place) / blur)) + noise
///
/// with place, size, blur, levels and the light's gradient unknown. The geometry is evaluated in
/// undistorted millimetres, since a lens makes discs egg-shaped in the picture; without a mapping K
/// is the identity. Pixels that belong to neighbours or debris are left out. The covariance is the
/// inverse of the information, times the residuals' own strength if that is larger; on textured
/// board the texture counts as correlated noise (texture_fit.h).
///
/// In     image; target; mapping may be null, then sizes are in px
/// Out    Found, Ambiguous, Rejected or NotFound with the reason; centre with covariance
/// Fails  never; invalid targets, or a size in mm without a mapping, are Rejected with the reason
/// Cost   discs: about 1 ms for 640 x 480 px, 13 ms on texture, more with debris
/// Source Reisfeld, Wolfson and Yeshurun 1995 (radial voting); docs/formulation.md, Locating
/// See    tests/vision/locate/locate_test.cc, tests/bench/locate/bench.cc
Detection locate(const Image& image,
                 const Target& target,
                 const CameraMapping* mapping = nullptr,
                 const LocateOptions& options = {});

}  // namespace panelcal
