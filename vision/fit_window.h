// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "panelcal/vision/fit_frame.h"
#include "panelcal/vision/image.h"

namespace panelcal::internal {

/// A pixel that takes part in a fit.
struct WindowPixel {
  Eigen::Vector2d at;        ///< in the fit frame
  Eigen::Matrix2d jacobian;  ///< d at / d pixel
  double value = 0;          ///< grey level
  double weight = 1;         ///< 1 / variance of its noise
  int x = 0;                 ///< in the picture
  int y = 0;
  bool in_fit = true;        ///< false: deep inside a large disc, only there for the score
  bool is_excluded = false;  ///< neighbour, debris
};

/// The pixels around a rim.
struct FitWindow {
  std::vector<WindowPixel> pixels;
  int x0 = 0;  ///< bounding box in the picture
  int y0 = 0;
  int width = 0;
  int height = 0;
};

/// How far the fit looks: more pixels settle the brightness gradient, which costs accuracy while it
/// is uncertain; fewer meet less of what is not the target.
struct WindowReach {
  double outside_px = 0;
  double inside_px = 0;
};
WindowReach window_reach(double radius_px);

/// Sigma of the noise that differs from pixel to pixel, from differences of neighbours: edges and
/// texture are too few or too smooth to matter to the median.
double white_noise_of(const FitWindow& window);

/// Collects the pixels of `image` whose distance from `center` is at most radius + reach; all
/// lengths in the fit frame's units.
FitWindow make_window(const Image& image,
                      const FitFrame& fit_frame,
                      const Eigen::Vector2d& center,
                      double radius,
                      const WindowReach& reach);

}  // namespace panelcal::internal
