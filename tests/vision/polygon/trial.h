// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "vision/locate/locate.h"
#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal::test {

/// One kind of picture of a square, diamond, cross or slot, of which many are drawn.
struct CellTrialOptions {
  std::uint64_t seed = 20240701;
  int n = 300;
  Shape shape = Shape::Square;
  Polarity polarity = Polarity::Bright;
  double size_px = 80;
  double width_of_size = 0.3;  ///< crosses
  double contrast = 140;       ///< grey levels of 255, as is the noise
  double noise = 2;
  double blur_px = 1;
  double max_angle_deg = 4;
  double light_gradient = 0;  ///< largest, either way, over the picture
  double weave = 0;
  double debris = 0;  ///< part of the outline under it, about
  int picture_px = 200;
  double full_scale = 255;
  bool with_mapping = false;
  double lens_at_corner_px = 0;
};

/// A picture with its truth.
struct CellTrial {
  Scene scene;  ///< the mark is features[0]; debris lies on it
  Camera camera;
  Target target;
  Eigen::Vector2d center_px;
  Position<frame::Optical> center;
  double size_px = 0;
  double angle_rad = 0;  ///< as TargetFit::angle means it
};

CellTrial draw_cell_trial(const CellTrialOptions& options, Random& random);

/// The mark itself, as a grid of cells.
Feature cell_feature(Shape shape, double size_mm, double width_mm, double angle_rad, double level);

/// Smallest covariance of the mark's place that any unbiased estimator may have, px^2.
///
/// From numeric derivatives of rendered pictures, with place, angle, size, width, blur, the
/// brightness planes of background and target all unknown; white noise; without the pixels that
/// debris touches.
Eigen::Matrix2d cell_bound(const CellTrialOptions& options, const CellTrial& trial);

/// Results.
struct CellStatistics {
  int n = 0;
  int n_found = 0;
  std::string first_failure;
  Eigen::Vector2d rmse_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double ratio = 0;  ///< root of the mean of (e / bound)^2, both coordinates
  double worst = 0;  ///< largest error, px
  double nees = 0;   ///< mean of e^T cov^-1 e / 2: 1 for an honest covariance
  double angle_nees = 0;
  double ms = 0;  ///< of processor time for one picture, mean

  std::string text() const;
};
CellStatistics run_cell_trials(const CellTrialOptions& options);

}  // namespace panelcal::test
