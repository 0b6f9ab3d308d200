// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "calib/base/number_text.h"
#include <Eigen/Core>

namespace panelcal::report {

/// `text` as it can stand in HTML, between tags and inside quoted attributes. Valid UTF-8 stays;
/// control and stray bytes become \xNN, so that no input can break the page.
std::string escaped(std::string_view text);

using internal::counted;
using internal::fixed;
using internal::grouped;
using internal::shortest;

/// Fixed point with a sign, also in front of positive numbers.
std::string fixed_signed(double value, int n_decimals);
/// Value and standard deviation with the decimals that show two digits of the latter, as HTML:
/// "+201.20 &#177; 0.92 ppm".
std::string with_sigma(double value, double sigma, std::string_view unit, bool is_signed = true);

/// "(15.000, 89.026)"
std::string point_text(const Eigen::Vector2d& p_mm);
/// "[0,1]", the step-and-repeat indices as everywhere else; empty for the panel itself.
std::string path_text(std::span<const int> path);

}  // namespace panelcal::report
