// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/base/units.h"
#include "vision/picture/image.h"

namespace panelcal {

/// Sharpness of a picture: the strength of its edges, relative to its brightness.
///
///   sharpness = (sum gx(x, y) gx(x, y+1) + sum gy(x, y) gy(x+1, y)) / (n mean^2)
///
/// with central differences g of noisy grey levels. Neighbouring rows (columns) see the same edges
/// but have noise of their own, so that noise adds to the scatter of the sharpness and not to its
/// mean: a dark picture does not seem sharp. For an edge of Gaussian blur s it is proportional to
/// 1 / s.
///
/// Out    1; about 0 for a picture that shows nothing, also slightly below
/// Cost   one pass, 1 ms for 640 x 480 px
/// See    tests/vision/locate/focus_test.cc
double sharpness(const Image& image);

/// A picture's sharpness at a height of the camera.
struct FocusSample {
  Length z;
  double sharpness = 0;
};

/// The sharpest height of a series of pictures.
struct FocusPeak {
  Length z;
  Length sigma;       ///< of z, from the samples' scatter about the curve
  Length half_depth;  ///< defocus at which edges are sqrt(2) times as wide as at best
};

/// Fits the sharpness curve around its greatest sample.
///
///   1 / sharpness^2 = a + b z + c z^2
///
/// which is exact for edges whose blur grows as s^2 = s0^2 (1 + (z - z0)^2 / D^2), as that of a
/// lens does; samples of less than half the greatest sharpness are left out, for there other blurs
/// begin to matter. Weighted as if all sharpnesses were equally uncertain; that uncertainty comes
/// from the residuals, and sigma counts by nu / (nu - 2) that few of them estimate it.
///
/// In     samples: any order; 5 or more near the peak
/// Out    empty: `reason` says why: too few samples, no peak that stands out of the scatter, or the
///        sharpest place at an end of the range
/// See    tests/vision/locate/focus_test.cc
std::optional<FocusPeak> fit_focus_peak(std::span<const FocusSample> samples, std::string* reason);

}  // namespace panelcal
