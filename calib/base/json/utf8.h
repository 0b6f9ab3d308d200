// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace panelcal {

/// Length of the UTF-8 sequence at the start of `text`, 0 if it is not one (RFC 3629).
/// Precondition: `text` is not empty
std::size_t utf8_length(std::string_view text);

}  // namespace panelcal
