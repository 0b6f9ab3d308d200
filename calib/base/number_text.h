// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

// Not installed: numbers inside of sentences.
namespace panelcal::internal {

/// Fixed point, "0.0" rather than "-0.0"; "not a number" where it is NaN.
std::string fixed(double value, int n_decimals);
/// In the fewest digits, at most six of them: 0.5, 2,000, 61.3; thousands are grouped.
std::string shortest(double value);
/// 20,000
std::string grouped(std::int64_t n);
/// "1 hole", "20,000 holes"
std::string counted(std::int64_t n, std::string_view noun);

}  // namespace panelcal::internal
