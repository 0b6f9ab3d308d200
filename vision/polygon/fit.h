// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/frame.h"
#include "vision/picture/image.h"
#include "vision/polygon/fit_result.h"
#include "vision/polygon/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

struct CellFitOptions {
  /// Distance around the pattern to which pixels are used, fit frame units: they settle the
  /// brightness plane. With Unknown outside it may be 0.
  double reach = 20;
  /// Greatest error of the start, fit frame units at the pattern's rim. Larger takes longer.
  double start_error = 2;
  /// Largest sigma of an edge, px; blurrier ones are no edges.
  double max_sigma_px = 6;
  /// The image's pixels are means of squares of this number of pixels of the picture that the fit
  /// frame belongs to; "px" is then one of the image's.
  int reduction = 1;
  int image_x0 = 0;  ///< column in that picture of the image's first pixel, px
  int image_y0 = 0;
  /// One quick fit, without noise, covariance and quality: a start for a better one.
  bool is_rough = false;
  /// The picture tells nothing about the pattern's place along its x: a stripe.
  bool is_blind_along_x = false;
  /// The ground may have texture, such as glass weave: then it is modelled.
  bool may_be_textured = false;
  /// Only every n-th pixel of rows and columns takes part: quicker yet, for rough fits.
  int stride = 1;
  /// The start is the state of a rough fit, levels included: it needs no other.
  bool is_refined = false;
};

/// Fits a pattern to the pixels around it by maximum likelihood.
///
/// A Huber fit, then plain fits without the pixels that the model cannot explain, found in the
/// residuals and in their local means, then one weighted by the noise inside and outside.
/// Saturated pixels count only where the model is not saturated.
///
/// In     model; start: within start_error of the truth, levels are not needed; reach
/// Out    converged false if there is no such pattern
/// Cost   1.5 ms for a square of 80 px
/// Source Nocedal and Wright 2006, 10.3; Huber 1964
/// See    tests/vision/polygon/detector_slow_test.cc
CellFit fit_cells(const Image& image,
                  const FitFrame& fit_frame,
                  const CellModel& model,
                  const CellState& start,
                  const CellFitOptions& options);

/// A pattern point in the fit frame and its covariance, frame units squared.
struct CellPlace {
  Eigen::Vector2d at;
  Eigen::Matrix2d cov;
};
CellPlace place_of(const CellModel& model, const CellFit& fit, const Eigen::Vector2d& v);

}  // namespace panelcal::internal
