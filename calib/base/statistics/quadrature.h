// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace panelcal::internal {

/// Places and weights that integrate polynomials up to degree 2 n - 1 exactly.
struct Quadrature {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Gauss and Legendre's rule of n points over [low, high].
///
/// Source Abramowitz and Stegun 25.4.29; nodes by Newton's iteration on the three-term recurrence
Quadrature gauss_legendre(int n, double low, double high);

}  // namespace panelcal::internal
