// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

/// The chance that an F variable of (numerator, denominator) degrees of freedom exceeds a value; 1
/// for values of zero and below, and no number for one. An infinite denominator is a chi-square.
///
///   P(F > f) = y^(d2/2) sum over j < d1/2 of (d2/2)_j / j! (1 - y)^j,   y = d2 / (d2 + d1 f)
///
/// Numerators are even here, places having two coordinates, so that the sum is finite; denominators
/// need not be whole, for variances that are pieced together have effective degrees of freedom.
///
/// In     numerator: even, 2 or more; denominator: above 0
/// Source Abramowitz and Stegun 1964, 26.6.4; Satterthwaite 1946 (effective degrees of freedom)
/// See    tests/calib/spindle/f_exceedance_test.cc
double f_exceedance(double f, int numerator, double denominator);

}  // namespace panelcal
