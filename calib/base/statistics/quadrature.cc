// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/quadrature.h"

#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

struct Legendre {
  double value = 0;
  double slope = 0;
};

Legendre legendre_polynomial(int n, double x) {
  double before = 1;
  double here = x;
  for (int k = 2; k <= n; ++k) {
    const double next = ((2 * k - 1) * x * here - (k - 1) * before) / k;
    before = here;
    here = next;
  }
  return {here, n * (x * here - before) / (x * x - 1)};
}

}  // namespace

Quadrature gauss_legendre(int n, double low, double high) {
  constexpr int kMostSteps = 50;
  constexpr double kRounding = 1e-15;
  Quadrature rule;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    Legendre p = legendre_polynomial(n, x);
    for (int step = 0; step < kMostSteps; ++step) {
      const double change = p.value / p.slope;
      x -= change;
      p = legendre_polynomial(n, x);
      if (std::abs(change) < kRounding) break;
    }
    const double half = 0.5 * (high - low);
    rule.nodes.push_back(low + half * (1 + x));
    rule.weights.push_back(half * 2 / ((1 - x * x) * p.slope * p.slope));
  }
  return rule;
}

}  // namespace panelcal::internal
