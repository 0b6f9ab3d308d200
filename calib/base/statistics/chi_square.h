// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

/// The chance that a chi-square variable with the given degrees of freedom (1 or more) exceeds a
/// value; 1 for values of zero and below, and no number for one.
///
/// Source Abramowitz and Stegun 1964, 26.4.4 and 26.4.5 (finite sums)
/// See    tests/calib/base/statistics/chi_square_test.cc
double chi_square_exceedance(double chi_square, int degrees_of_freedom);

}  // namespace panelcal
