// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

// The number of nights that a control chart runs, on the average, from its start to a false alarm,
// if the scores it is fed are independent and standard normal; and the limit for a wanted number.
//
// Both by the integral equation of the run length, whose kernel is smooth, so that Gauss and
// Legendre's rule converges exponentially; a Markov chain of cells (Brook and Evans 1972) has the
// same solution in the limit of many cells.

/// Of the exponentially weighted moving average of vectors of n_axes scores, held against `limit`
/// in standard deviations that it has after many nights:
///
///   z' = (1 - weight) z + weight u,   alarm if |z| > limit sqrt(weight / (2 - weight))
///
/// |z'| depends on z by its length alone, by the noncentral chi distribution.
/// In     n_axes >= 1; 0.02 <= weight <= 1 (1: each night by itself); 0 < limit < 10
/// Source Crowder 1987 (one axis); Rigdon 1995 (several)
/// See    tests/calib/charts/run_length_test.cc
double ewma_run_length(int n_axes, double weight, double limit);

/// Of a one-sided cumulative sum: s' = max(0, s + u - allowance), alarm if s > limit.
///
/// Source Page 1954; van Dobben de Bruyn 1968
double cusum_run_length(double allowance, double limit);

/// The limits that give a mean run length of this number of nights, 2 to 1e6.
double ewma_limit(int n_axes, double weight, double nights);
double cusum_limit(double allowance, double nights);

}  // namespace panelcal
