// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "calib/base/number_text.h"
#include <Eigen/Core>

// Numbers and places as the text of commands has them.
namespace panelcal::report {

using internal::counted;
using internal::fixed;
using internal::grouped;

/// Fixed point with a sign, also in front of positive numbers.
std::string fixed_signed(double value, int n_decimals);

/// Words of others, fit for one line of a terminal: without control characters.
std::string one_line(std::string text);

/// "(15.000, 89.026)"
std::string point_text(const Eigen::Vector2d& p_mm);
/// "[0,1]", the step-and-repeat indices as everywhere else; empty for the panel itself.
std::string path_text(std::span<const int> path);

}  // namespace panelcal::report
