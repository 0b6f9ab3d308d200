// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "calib/advice/target_design.h"

namespace panelcal::plan {

/// Borders of the colours, in times the noise.
inline constexpr std::array kLevels = {
    0.5, 0.6, 0.7, 0.85, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0};
/// From cool and pale (well known) to warm and deep; told apart by colour-blind people by their
/// lightness alone.
inline constexpr std::array<std::string_view, kLevels.size() + 1> kColors = {"#eef6f5",
                                                                             "#e2f1ee",
                                                                             "#d3eae5",
                                                                             "#c2e2da",
                                                                             "#b5dccd",
                                                                             "#d6e6bd",
                                                                             "#f2ebb4",
                                                                             "#f9e09a",
                                                                             "#f8d080",
                                                                             "#f5bb6a",
                                                                             "#efa25a",
                                                                             "#e6864f",
                                                                             "#d96a48",
                                                                             "#c64f42",
                                                                             "#ab383b",
                                                                             "#872634"};

/// Index of the colour of a leverage; what lies on a line belongs to the band above it.
std::size_t band_of(double leverage);

/// The place where the leverage is least, by compass search: it is convex.
Eigen::Vector2d calmest(const LeverageMap& leverage,
                        const Eigen::Vector2d& start_mm,
                        double step_mm);

/// The line of equal leverage around `center_mm`, inside of which all is less; it is cut off at
/// `farthest_mm`. Precondition: the leverage at the center is less than `level`.
std::vector<Eigen::Vector2d> level_line(const LeverageMap& leverage,
                                        const Eigen::Vector2d& center_mm,
                                        double level,
                                        double farthest_mm);

}  // namespace panelcal::plan
