// SPDX-License-Identifier: Apache-2.0
#include "surface/map/way_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// Greatest deviation of the profile between samples: |f''| h^2 / 8 where it is smooth, taken
/// twice.
double between_samples_mm(std::span<const double> heights_mm) {
  double largest_mm = 0;
  for (std::size_t i = 2; i < heights_mm.size(); ++i) {
    const double second_mm = heights_mm[i] - 2 * heights_mm[i - 1] + heights_mm[i - 2];
    largest_mm = std::max(largest_mm, std::abs(second_mm));
  }
  return largest_mm / 4;
}

}  // namespace

std::vector<std::size_t> fewest_cuts(std::span<const double> heights_mm, Length tolerance) {
  const std::size_t n = heights_mm.size();
  if (n < 3) return {};
  const double tolerance_mm = tolerance.in_mm();
  std::vector<std::size_t> n_pieces(n, std::numeric_limits<std::size_t>::max());
  std::vector<std::size_t> from(n, 0);
  n_pieces[0] = 0;
  for (std::size_t s = 0; s + 1 < n; ++s) {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    for (std::size_t t = s + 1; t < n && low <= high; ++t) {
      const double steps = static_cast<double>(t - s);
      const double slope = (heights_mm[t] - heights_mm[s]) / steps;
      if (slope >= low && slope <= high && n_pieces[s] + 1 < n_pieces[t]) {
        n_pieces[t] = n_pieces[s] + 1;
        from[t] = s;
      }
      low = std::max(low, slope - tolerance_mm / steps);
      high = std::min(high, slope + tolerance_mm / steps);
    }
  }
  std::vector<std::size_t> cuts;
  for (std::size_t t = from[n - 1]; t != 0; t = from[t]) cuts.push_back(t);
  std::ranges::reverse(cuts);
  return cuts;
}

std::size_t way_samples(double length_mm, Length cell) {
  constexpr double kPerCell = 4;
  return static_cast<std::size_t>(std::clamp(std::ceil(kPerCell * length_mm / cell.in_mm()),
                                             kPerCell,
                                             static_cast<double>(kMostWaySamples)));
}

Expected<std::vector<double>> way_cuts(
    const std::function<Expected<std::vector<double>>(std::size_t n)>& profile_mm,
    std::size_t least_samples,
    Length tolerance) {
  constexpr double kShare = 0.02;
  std::size_t n = std::clamp<std::size_t>(least_samples, 2, kMostWaySamples);
  while (true) {
    PANELCAL_TRY(const std::vector<double> heights_mm, profile_mm(n));
    const double between_mm = between_samples_mm(heights_mm);
    if (!(between_mm <= kShare * tolerance.in_mm())) {
      if (n == kMostWaySamples) break;
      n = std::min(2 * n, kMostWaySamples);
      continue;
    }
    std::vector<double> cuts;
    for (const std::size_t i : fewest_cuts(heights_mm, tolerance - mm(between_mm))) {
      cuts.push_back(static_cast<double>(i) / static_cast<double>(n));
    }
    return cuts;
  }
  return failure({Code::ArgumentInvalid,
                  {},
                  fmt::format("a move of more than {} samples over the surface", kMostWaySamples),
                  "shorter moves, or a wider height tolerance"});
}

}  // namespace panelcal
