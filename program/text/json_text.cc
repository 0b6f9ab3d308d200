// SPDX-License-Identifier: Apache-2.0
#include "program/text/json_text.h"

#include <cstddef>

#include "calib/base/append_format.h"
#include "program/text/utf8.h"
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

}  // namespace panelcal
