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

/// The noncentrality with which a chi-square variable would be as small as `chi_square`, or
/// smaller, with this chance: the upper confidence limit of how much is hidden in it. 0 where none
/// is left.
///
///   P(chi'^2(f, lambda) <= chi_square) = chance
///
/// In     0 < chance < 0.5
/// Out    exact below 500; beyond, to 1 % of its root ((chi'^2 / (f + lambda))^(1/3) nearly normal)
/// Source Abdel-Aty 1954, Biometrika 41, 538
double largest_noncentrality(double chi_square, int degrees_of_freedom, double chance);

}  // namespace panelcal
