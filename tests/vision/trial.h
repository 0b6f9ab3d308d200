// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "calib/base/statistics/random.h"
#include "vision/locate/locate.h"
#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal::test {

/// One kind of picture, of which many are drawn: everything not fixed here is random.
struct TrialOptions {
  std::uint64_t seed = 20240601;
  int n = 400;
  Shape shape = Shape::Disc;
  Polarity polarity = Polarity::Bright;
  double min_radius_px = 20;
  double max_radius_px = 60;
  double blur_px = 1;
  double contrast = 100;  ///< grey levels of 255, as are the next two
  double noise = 3;
  double weave = 0;
  double weave_period_px = 50;
  double full_scale = 255;
  double lens_at_corner_px = 0;  ///< move of the corner of a 640 x 480 picture by the lens
  double off_axis_px = 0;        ///< targets are up to this far from the optical axis
  double light_gradient = 0;     ///< largest, either way
  int n_neighbours = 0;
  bool with_mapping = true;
};

/// Results. Errors are in units of the Cramer-Rao bound of white noise, noise / contrast sqrt(2 s /
/// (sqrt(pi) R)) with s the edge blur, pixel width included.
struct TrialStatistics {
  int n = 0;
  int n_found = 0;
  std::string first_failure;
  Eigen::Vector2d rmse = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double nees_px = 0;  ///< mean of e^T cov^-1 e / 2: 1 for an honest covariance
  double nees_mm = 0;
  double radius_rms_px = 0;
  double blur_bias_px = 0;

  /// The figures in one line.
  std::string text() const;
};

/// A picture with its truth.
struct Trial {
  Scene scene;
  Camera camera;
  Target target;
  Eigen::Vector2d center_px;
  Position<frame::Optical> center;
  double radius_px = 0;
  double bound_px = 0;
};

Trial draw_trial(const TrialOptions& options, Random& random);
TrialStatistics run_trials(const TrialOptions& options);

/// A camera of 0.01 mm per px whose axis is in the middle of the picture.
Camera plain_camera(int width, int height);
/// A disc at a pixel of a plain camera.
Feature disc_at(const Camera& camera, double x_px, double y_px, double radius_px, double level);

}  // namespace panelcal::test
