// SPDX-License-Identifier: Apache-2.0
#include "surface/control/memory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

bool is_good_estimate(const HeightEstimate& estimate) {
  return std::isfinite(estimate.height.in_mm()) && std::isfinite(estimate.sigma.in_mm()) &&
         estimate.sigma >= Length();
}

HeightEstimate mean_of(std::span<const HeightEstimate> values) {
  double sum_mm = 0;
  double variance_mm2 = 0;
  for (const HeightEstimate& value : values) {
    sum_mm += value.height.in_mm();
    variance_mm2 += value.sigma.in_mm() * value.sigma.in_mm();
  }
  const double n = static_cast<double>(values.size());
  return {mm(sum_mm / n), mm(std::sqrt(variance_mm2) / n)};
}

/// Precondition: as many values as `kind` needs.
HeightEstimate average(std::vector<HeightEstimate> values, AverageKind kind) {
  std::ranges::stable_sort(values, {}, &HeightEstimate::height);
  const std::span<const HeightEstimate> sorted(values);
  const std::size_t n = sorted.size();
  switch (kind) {
    case AverageKind::Mean:
      break;
    case AverageKind::Median:
      return mean_of(sorted.subspan((n - 1) / 2, n % 2 == 1 ? 1 : 2));
    case AverageKind::MidRange:
      // A single value is its own smallest and greatest, and no better known for that.
      if (n > 1) return mean_of(std::vector{sorted.front(), sorted.back()});
      break;
    case AverageKind::TrimmedMean:
      return mean_of(sorted.subspan(1, n - 2));
  }
  return mean_of(sorted);
}

}  // namespace

tl::expected<void, std::string> SurfaceMemory::check(
    std::span<const HeightEstimate> heights) const {
  if (heights.empty()) {
    return tl::unexpected<std::string>("there is no height; expected one for each Z axis");
  }
  if (n_axes_ != 0 && heights.size() != n_axes_) {
    return tl::unexpected(fmt::format(
        "there are heights of {} Z axes; expected {} as before", heights.size(), n_axes_));
  }
  if (std::ranges::all_of(heights, is_good_estimate)) return {};
  return tl::unexpected<std::string>(
      "a height is not finite, or its sigma is negative; expected finite numbers and a sigma of 0 "
      "or more");
}

tl::expected<void, std::string> SurfaceMemory::store(int n, std::vector<HeightEstimate> heights) {
  if (n < 0) {
    return tl::unexpected(
        fmt::format("there is no L{} in the surface memory; expected L0 or higher", n));
  }
  if (const auto good = check(heights); !good) return good;
  n_axes_ = heights.size();
  by_number_.insert_or_assign(n, std::move(heights));
  return {};
}

tl::expected<std::vector<HeightEstimate>, std::string> SurfaceMemory::load(int n) const {
  const auto found = by_number_.find(n);
  if (found != by_number_.end()) return found->second;
  return tl::unexpected(
      fmt::format("L{0} of the surface memory is empty; expected G73L{0} or G74L{0} before it", n));
}

tl::expected<void, std::string> SurfaceMemory::add(std::vector<HeightEstimate> heights) {
  if (to_average_.size() == kAveragingCapacity) {
    return tl::unexpected(fmt::format(
        "the averaging area is full; expected at most {} values before G74", kAveragingCapacity));
  }
  if (const auto good = check(heights); !good) return good;
  n_axes_ = heights.size();
  to_average_.push_back(std::move(heights));
  return {};
}

tl::expected<std::vector<HeightEstimate>, std::string> SurfaceMemory::take_average(
    AverageKind kind) {
  const std::size_t n_needed = kind == AverageKind::TrimmedMean ? 3 : 1;
  if (to_average_.size() < n_needed) {
    return tl::unexpected(fmt::format("the averaging area holds {} values; expected at least {}{}",
                                      to_average_.size(),
                                      n_needed,
                                      n_needed == 3 ? " for SPAV,T" : " from G73 without L"));
  }
  std::vector<HeightEstimate> averages;
  for (std::size_t axis = 0; axis < n_axes_; ++axis) {
    std::vector<HeightEstimate> values;
    for (const auto& heights : to_average_) values.push_back(heights[axis]);
    averages.push_back(average(std::move(values), kind));
  }
  to_average_.clear();
  return averages;
}

}  // namespace panelcal
