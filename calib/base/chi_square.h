// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

/// The chance that a chi-square variable with the given degrees of freedom (1 or more) exceeds a
/// value; 1 for values of zero and below, and no number for one.
///
/// Source Abramowitz and Stegun 1964, 26.4.4 and 26.4.5 (finite sums)
/// See    tests/calib/base/statistics/chi_square_test.cc
double chi_square_exceedance(double chi_square, int degrees_of_freedom);

/// The value that a chi-square variable exceeds with a probability above 0 and below 1.
double chi_square_limit(double probability, int degrees_of_freedom);

/// The chance that a non-central chi-square variable exceeds a value: the sum of squares of
/// `degrees_of_freedom` standard normal variables whose means' squares add up to `noncentrality`.
///
/// Source Abramowitz and Stegun 1964, 26.4.25 (a mixture by Poisson's weights)
/// Cost   O(noncentrality + degrees of freedom)
double noncentral_chi_square_exceedance(double chi_square,
                                        int degrees_of_freedom,
                                        double noncentrality);

/// The noncentrality that a chi-square test notices with probability `power`, if it refuses healthy
/// data with probability `false_alarm`, less than `power`.
///
/// Source Baarda 1968 (lambda_0)
double noticed_noncentrality(double false_alarm, double power, int degrees_of_freedom);

}  // namespace panelcal
