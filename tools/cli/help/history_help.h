// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// The help below the options of `history` and its own commands; empty for another one.
std::string_view history_footer(std::string_view command);

}  // namespace panelcal
