// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/place_text.h"

#include <cmath>

#include <fmt/format.h>

namespace panelcal::report {

std::string fixed_signed(double value, int n_decimals) {
  const std::string text = fixed(value, n_decimals);
  return std::isnan(value) || text.starts_with('-') ? text : "+" + text;
}

std::string point_text(const Eigen::Vector2d& p_mm) {
  return fmt::format("({}, {})", fixed(p_mm.x(), 3), fixed(p_mm.y(), 3));
}

std::string path_text(std::span<const int> path) {
  return path.empty() ? std::string() : fmt::format("[{}]", fmt::join(path, ","));
}

}  // namespace panelcal::report
