// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include "vision/picture/image.h"
#include "vision/render/camera.h"
#include "vision/render/scene.h"

namespace panelcal {

/// The light on the sensor, without noise and before it is counted: grey levels, by rows.
///
/// A pixel's share of a feature is the integral over the feature of lens blur and pixel square,
/// computed as a line integral along the feature's outline mapped into the picture:
///
///   share(u) = closed integral G(x - u_x) g(y - u_y) dy,   g = box * Gauss, G = its integral
///
/// by quadrature that converges exponentially; there is no supersampling and no error above 1e-6.
/// Pictures (Feature::Shape::Picture) are interpolated with cubic splines.
///
/// In     features in Optical; camera.blur_px >= 0.2; camera.tilt below 80 degrees
/// Cost   1 ms for 640 x 480 px with a disc of 40 px radius, 15 ms with weave
/// See    tests/vision/render/render_test.cc
std::vector<double> render_levels(const Scene& scene, const Camera& camera);

/// Pixels that features touch: those of which they cover at least `least_share`. By rows.
std::vector<bool> touched_pixels(std::span<const Feature> features,
                                 const Camera& camera,
                                 double least_share = 1e-3);

/// The picture that a camera takes of grey levels: noise, hot pixels, whole levels from 0 to full
/// scale.
///
/// In     levels: one for each pixel of the camera
Image expose(std::span<const double> levels, const Camera& camera, Random& random);

/// Renders a picture whose truth is known exactly: expose(render_levels(scene, camera)). Equal
/// arguments give equal pictures.
Image render(const Scene& scene, const Camera& camera, Random& random);

}  // namespace panelcal
