// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// The help below the options of `calibrate camera` and the others that look at marks and
/// plates; empty for another command.
std::string_view calibrate_footer(std::string_view command);

}  // namespace panelcal
