// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal {

/// Appends `text` as a JSON string with its quotes. Bytes that are not valid UTF-8 come out as the
/// code point of the same number (Latin-1), so that the result is always valid JSON.
void append_json_string(std::string& out, std::string_view text);

}  // namespace panelcal
