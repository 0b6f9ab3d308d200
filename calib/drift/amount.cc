// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/amount.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace panelcal {
namespace {

std::string shown(double value, const std::string& unit, std::string_view sign) {
  const auto format = [sign](double v, int decimals, std::string_view u) {
    const std::string number =
        sign == "+" ? fmt::format("{:+.{}f}", v, decimals) : fmt::format("{:.{}f}", v, decimals);
    return fmt::format("{} {}", number, u);
  };
  if (unit == "mm") {
    return std::abs(value) < 1 ? format(value * 1e3, 1, "um") : format(value, 3, "mm");
  }
  if (unit == "rad") return format(value * 1e3, 3, "mrad");
  return sign == "+" ? fmt::format("{:+.4g} {}", value, unit)
                     : fmt::format("{:.4g} {}", value, unit);
}

}  // namespace

std::string amount(double value, const std::string& unit) {
  return shown(value, unit, "");
}

std::string signed_amount(double value, const std::string& unit) {
  return shown(value, unit, "+");
}

}  // namespace panelcal
