// SPDX-License-Identifier: Apache-2.0
#include "program/text/json_text.h"

#include <cstddef>
#include <iterator>

#include "program/text/utf8.h"
#include <fmt/format.h>

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
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", byte);
      length = 1;
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  out += '"';
}

}  // namespace panelcal
