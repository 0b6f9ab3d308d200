// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "calib/base/units.h"
#include "calib/camera/mapping.h"

namespace panelcal {

/// Camera that takes a picture.
struct Camera {
  CameraMapping mapping;
  int width = 640;
  int height = 480;
  double blur_px = 1.0;     ///< sigma of the lens's Gaussian point spread; the pixel comes on top
  double noise = 0;         ///< sigma per pixel, grey levels of the picture
  double full_scale = 255;  ///< 255 or 65535
  /// Grey levels per electron: the light's own noise has the variance shot_noise * level.
  double shot_noise = 0;
  double hot_pixels = 0;            ///< share of the pixels that are too bright
  std::uint64_t hot_pixels_at = 1;  ///< seed: they are the sensor's, the same in every picture
  /// The board leans away from the picture's plane, about a line through the optical axis. It is
  /// foreshortened across this line, so that discs become ellipses; perspective is left out, which
  /// moves their middles by r^2 sin(tilt) / distance, nanometres.
  Angle tilt = {};
  Angle tilt_axis = {};  ///< of that line against x
};

}  // namespace panelcal
