// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// The refusal of a geometry function for numbers that it cannot use: what is wrong and what was
/// expected.
inline tl::unexpected<std::string> refusal(std::string what) {
  return tl::unexpected<std::string>(std::move(what));
}

inline tl::unexpected<std::string> not_finite() {
  return refusal("a number is not finite; expected lengths in mm");
}

inline bool all_finite(std::initializer_list<double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

}  // namespace panelcal::sieb_meyer
