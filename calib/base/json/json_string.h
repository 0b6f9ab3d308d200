// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Not installed.
namespace panelcal {

/// Appends `text` as a JSON string with its quotes, for JSON Lines. Bytes that are not valid UTF-8
/// come out as the code point of the same number (Latin-1), so that the result is always valid JSON
/// and names of files keep all of their bytes.
void append_json_string(std::string& out, std::string_view text);

namespace internal {

/// The same in ASCII, for files; what is not valid UTF-8 becomes U+FFFD.
std::string ascii_json_string(std::string_view text);

}  // namespace internal
}  // namespace panelcal
