// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/table/fit.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A look where a fit that did not use it has it.
struct TablePrediction {
  std::size_t i_look = 0;
  Eigen::Vector2d error_mm = Eigen::Vector2d::Zero();  ///< predicted minus seen
  double chi_square = 0;  ///< of two coordinates, the prediction's covariance counted
};

/// This number of parts of the looks is predicted, one after the other, from the rest.
inline constexpr std::size_t kTableFolds = 5;

/// Predicts the looks of a part, i_fold from 0, which chance has drawn once and for all, from all
/// others; none of a dot that only they show. Empty if the others are too few for a fit.
std::vector<TablePrediction> predict(const TableData& data,
                                     TableFitOptions options,
                                     std::size_t i_fold);

/// Takes looks out that are not where the others have them, and says so of each in words.
///
/// Predicted they are, not fitted: a smooth map bends through one look that is alone at its place.
/// Out of line is what is five standard deviations off, stated ones or those of the median's
/// scatter, whichever is more; the worst ones first, since they bend what their neighbours are
/// predicted by.
///
/// Cost   kTableFolds fits, and as many again while something is found
/// See    tests/machine/calibrate/table/run_test.cc
std::vector<std::string> leave_out_outliers(const TableFitOptions& options, TableData& data);

}  // namespace panelcal::internal
