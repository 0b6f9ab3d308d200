// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace panelcal::test {

/// The chance that of n independent tries, each with chance p, at most k come true.
///
/// In     0 < p < 1
inline double binomial_at_most(int k, int n, double p) {
  if (k < 0) return 0;
  if (k >= n) return 1;
  double sum = 0;
  double log_one = n * std::log1p(-p);  // of exactly i
  for (int i = 0; i <= k; ++i) {
    sum += std::exp(log_one);
    log_one += std::log((n - i) / (i + 1.0)) + std::log(p) - std::log1p(-p);
  }
  return std::min(1.0, sum);
}

/// The smallest k with at_most(k) >= chance.
inline int binomial_quantile(double chance, int n, double p) {
  int k = 0;
  while (k < n && binomial_at_most(k, n, p) < chance) ++k;
  return k;
}

}  // namespace panelcal::test
