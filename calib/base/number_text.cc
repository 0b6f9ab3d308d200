// SPDX-License-Identifier: Apache-2.0
#include "calib/base/number_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

std::string with_separators(std::string digits) {
  const std::size_t begin = digits.starts_with('-') ? 1 : 0;
  std::size_t end = std::min(digits.find('.'), digits.size());
  while (end > begin + 3) {
    end -= 3;
    digits.insert(end, ",");
  }
  return digits;
}

}  // namespace

std::string fixed(double value, int n_decimals) {
  if (std::isnan(value)) return "not a number";
  const std::string text = fmt::format("{:.{}f}", value, n_decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero && text.starts_with('-') ? text.substr(1) : text;
}

std::string shortest(double value) {
  if (!std::isfinite(value)) return fixed(value, 0);
  if (std::abs(value) >= 1e15 || (value != 0 && std::abs(value) < 1e-6)) {
    return fmt::format("{:.3g}", value);
  }
  const int before_point =
      value == 0 ? 1 : static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  std::string text = fmt::format("{:.{}f}", value, std::clamp(6 - before_point, 0, 9));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return with_separators(std::move(text));
}

std::string grouped(std::int64_t n) {
  return with_separators(std::to_string(n));
}

std::string counted(std::int64_t n, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(n), noun, n == 1 ? "" : "s");
}

}  // namespace panelcal::internal
