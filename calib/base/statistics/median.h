// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace panelcal {

/// The upper one of an even number; 0 without a value. The values are left in another order.
template <class T>
double median(std::vector<T>&& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

template <class T>
double median(const std::vector<T>& values) {
  return median(std::vector<T>(values));
}

/// The sigma of normal values over the median of their magnitudes.
inline constexpr double kSigmasPerMedian = 1.4826;

}  // namespace panelcal
