// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/place_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal::report {

std::string fixed_signed(double value, int n_decimals) {
  const std::string text = fixed(value, n_decimals);
  return std::isnan(value) || text.starts_with('-') ? text : "+" + text;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; }, ' ');
  return text;
}

std::string point_text(const Eigen::Vector2d& p_mm) {
  return fmt::format("({}, {})", fixed(p_mm.x(), 3), fixed(p_mm.y(), 3));
}

std::string path_text(std::span<const int> path) {
  return path.empty() ? std::string() : fmt::format("[{}]", fmt::join(path, ","));
}

}  // namespace panelcal::report
