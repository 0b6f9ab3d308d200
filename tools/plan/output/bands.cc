// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/bands.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::plan {

std::size_t band_of(double leverage) {
  return static_cast<std::size_t>(std::ranges::upper_bound(kLevels, leverage * (1 + 1e-9)) -
                                  kLevels.begin());
}

Eigen::Vector2d calmest(const LeverageMap& leverage,
                        const Eigen::Vector2d& start_mm,
                        double step_mm) {
  Eigen::Vector2d at = start_mm;
  const auto value = [&](const Eigen::Vector2d& p) {
    return leverage(position_mm<frame::Nominal>(p));
  };
  double best = value(at);
  for (int i = 0; i < 200 && step_mm > 1e-6; ++i) {
    bool has_moved = false;
    for (const Eigen::Vector2d& way : {Eigen::Vector2d(1, 0),
                                       Eigen::Vector2d(-1, 0),
                                       Eigen::Vector2d(0, 1),
                                       Eigen::Vector2d(0, -1)}) {
      const Eigen::Vector2d next = at + step_mm * way;
      const double there = value(next);
      if (there >= best * (1 - 1e-12)) continue;
      best = there;
      at = next;
      has_moved = true;
    }
    if (!has_moved) step_mm /= 2;
  }
  return at;
}

std::vector<Eigen::Vector2d> level_line(const LeverageMap& leverage,
                                        const Eigen::Vector2d& center_mm,
                                        double level,
                                        double farthest_mm) {
  constexpr int kRays = 240;
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRays;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    double inside = 0;
    double outside = farthest_mm;
    const auto is_below = [&](double r) {
      return leverage(position_mm<frame::Nominal>((center_mm + r * ray).eval())) < level;
    };
    if (is_below(outside)) inside = outside;
    for (int k = 0; k < 40 && outside - inside > 1e-3; ++k) {
      const double middle = (inside + outside) / 2;
      (is_below(middle) ? inside : outside) = middle;
    }
    line.push_back(center_mm + inside * ray);
  }
  return line;
}

}  // namespace panelcal::plan
