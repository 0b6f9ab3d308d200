// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/normal_mixture.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/distributions.h"

namespace panelcal {

double NormalMixture::mean() const {
  double sum = 0;
  for (const Part& p : parts) sum += p.weight * p.mean;
  return sum;
}

double NormalMixture::variance() const {
  const double m = mean();
  double sum = 0;
  for (const Part& p : parts) sum += p.weight * (p.variance + (p.mean - m) * (p.mean - m));
  return sum;
}

double NormalMixture::score(double value) const {
  double less = 0;
  double more = 0;
  for (const Part& p : parts) {
    const double z = (value - p.mean) / std::sqrt(p.variance);
    less += p.weight * normal_exceedance(-z);
    more += p.weight * normal_exceedance(z);
  }
  return normal_score(less, more);
}

NormalMixture NormalMixture::condensed(int n) const {
  std::vector<Part> sorted = parts;
  std::ranges::sort(sorted, {}, &Part::variance);
  NormalMixture out;
  NormalMixture group;
  double sum = 0;
  const auto close = [&] {
    double weight = 0;
    for (const Part& p : group.parts) weight += p.weight;
    if (weight > 0) {
      for (Part& p : group.parts) p.weight /= weight;
      out.parts.push_back({weight, group.mean(), group.variance()});
    }
    group.parts.clear();
  };
  for (const Part& p : sorted) {
    group.parts.push_back(p);
    sum += p.weight;
    if (sum * n >= static_cast<double>(out.parts.size()) + 1) close();
  }
  close();
  return out;
}

}  // namespace panelcal
