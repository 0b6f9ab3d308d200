// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// A coordinate of the program, X# or Y#, has a decimal point: its digits are not those that the
/// header declares. Tool data, comments and formats do not count.
///
/// Cost   O(n), n being the text up to the first such point
/// See    tests/program/text/decimal_points_test.cc
bool has_decimal_coordinates(std::string_view program);

}  // namespace panelcal
