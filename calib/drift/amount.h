// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal {

/// A value as people read it: "12.3 um" of 0.0123 mm, "0.123 mrad" of rad, "4.2 px" of other units.
std::string amount(double value, const std::string& unit);
/// The same with its sign always: "+12.3 um".
std::string signed_amount(double value, const std::string& unit);

}  // namespace panelcal
