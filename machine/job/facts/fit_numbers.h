// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "calib/panel/model.h"
#include "program/walk/survey.h"
#include <Eigen/Core>

namespace panelcal::facts {

struct Uncertain {
  double value = 0;
  double sigma = 0;  ///< one standard deviation, same unit
};

/// A fit in the words of the trade, each number with its uncertainty.
///
/// The map is R(rotation) [scale_x, shear; 0, scale_y] about the targets' centroid plus a shift.
struct FitNumbers {
  PanelModel model = PanelModel::Offset;
  Uncertain rotation_rad;   ///< counter-clockwise
  Uncertain stretch_x_ppm;  ///< scale - 1
  Uncertain stretch_y_ppm;  ///< |scale| - 1
  Uncertain shear_ppm;
  bool is_mirrored = false;
  Eigen::Vector2d centroid_mm = Eigen::Vector2d::Zero();  ///< of the targets, before the fit
  Uncertain shift_x_mm;                                   ///< of the centroid
  Uncertain shift_y_mm;
  double chi_square = 0;
  int degrees_of_freedom = 0;
};

/// Propagates the covariance of the six affine coefficients, to first order. Empty without a fit.
///
/// See    tests/machine/job/facts/fit_numbers_test.cc
std::optional<FitNumbers> fit_numbers(const SeriesResult& series);

/// The meaning of a chi square for the noise, as a word of the schema, with no more certainty than
/// it has: "unchecked" (no equation to spare), "as_expected", "weak" (as expected, but one spare
/// equation checks little), "rather_large", "too_large", "too_large_weak", "too_small".
std::string_view chi_square_meaning(double chi_square, int degrees_of_freedom);

}  // namespace panelcal::facts
