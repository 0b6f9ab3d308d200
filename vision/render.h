// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/base/random.h"
#include "panelcal/calib/base/units.h"
#include "panelcal/calib/camera_mapping.h"
#include "panelcal/vision/image.h"

namespace panelcal {

/// What lies on a panel: marks, and things that are not marks.
struct Feature {
  enum class Shape { Disc, Ring, Rectangle };

  Shape shape = Shape::Disc;
  Position<frame::Optical> center;
  Length size;        ///< outer diameter; a rectangle's length
  Length inner_size;  ///< a ring's hole; a rectangle's width
  Angle angle;        ///< of a rectangle's length against x
  double level = 0;   ///< brightness, 0 to 1 of full scale
};

/// The glass weave of the laminate: fixed to the panel, so that overlapping pictures agree.
struct Weave {
  double amplitude = 0;                                          ///< of full scale
  Length period = mm(0.5);                                       ///< from yarn to yarn but one
  std::uint64_t seed = 1;                                        ///< of the yarns' irregularity
  Transform<frame::Nominal, frame::Optical> panel_from_optical;  ///< where the picture lies
};

/// A piece of panel under the camera. Features are painted in order: later ones cover earlier ones.
struct Scene {
  std::vector<Feature> features;
  double background = 0.3;  ///< brightness, 0 to 1 of full scale
  Weave weave;              ///< seen on the background only
  /// Relative change of the light from the left to the right edge of the picture, and from top to
  /// bottom. It multiplies everything, as light does.
  Eigen::Vector2d light_gradient = Eigen::Vector2d::Zero();
  double vignetting = 0;  ///< relative loss of light in the corners
};

/// How a picture is taken.
struct Camera {
  CameraMapping mapping;
  int width = 640;
  int height = 480;
  double blur_px = 1.0;     ///< sigma of the lens's Gaussian point spread; the pixel comes on top
  double noise = 0;         ///< sigma per pixel, grey levels of the picture
  double full_scale = 255;  ///< 255 or 65535
};

/// Renders a picture whose truth is known exactly.
///
/// A pixel's share of a feature is the integral over the feature of lens blur and pixel square,
/// computed as a line integral along the feature's outline mapped into the picture:
///
///   share(u) = closed integral G(x - u_x) g(y - u_y) dy,   g = box * Gauss, G = its integral
///
/// by the trapezoid rule, which converges exponentially on a smooth closed curve (Trefethen and
/// Weideman 2014); there is no supersampling and no error above 1e-6. Values are quantised to whole
/// grey levels and clipped to 0 .. full scale. Equal arguments give equal pictures.
///
/// In     features in Optical; camera.blur_px >= 0.2
/// Cost   about 30 ms for 640 x 480 px with noise and weave
/// See    tests/vision/render_test.cc
Image render(const Scene& scene, const Camera& camera, Random& random);

}  // namespace panelcal
