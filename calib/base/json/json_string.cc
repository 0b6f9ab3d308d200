// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/json_string.h"

#include <cstddef>

#include "calib/base/append_format.h"
#include "calib/base/json/utf8.h"
#include <nlohmann/json.hpp>

namespace panelcal {

void append_json_string(std::string& out, std::string_view text) {
  out += '"';
  while (!text.empty()) {
    const auto byte = static_cast<unsigned char>(text.front());
    std::size_t length = utf8_length(text);
    if (byte == '"' || byte == '\\') {
      out += '\\';
      out += text.front();
    } else if (byte < 0x20 || byte == 0x7F || length == 0) {
      internal::append_format(out, "\\u{:04x}", byte);
      length = 1;
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  out += '"';
}

namespace internal {

std::string ascii_json_string(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace internal
}  // namespace panelcal
