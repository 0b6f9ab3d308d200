// SPDX-License-Identifier: Apache-2.0
#include "program/text/xml_text.h"

#include <cstddef>

#include "calib/base/json/utf8.h"

namespace panelcal {
namespace {

/// Entity of a character of markup; empty for all others.
std::string_view entity(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

/// XML 1.0 knows neither control characters but tab and line ends, nor U+FFFE and U+FFFF.
bool is_allowed(std::string_view character) {
  const auto first = static_cast<unsigned char>(character.front());
  if (character.size() == 1)
    return (first >= 0x20 && first != 0x7F) || first == '\t' || first == '\n';
  return character != "\xEF\xBF\xBE" && character != "\xEF\xBF\xBF";
}

}  // namespace

void append_xml_text(std::string& out, std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, length == 0 ? 1 : length);
    if (length == 0 || !is_allowed(character)) {
      out += '?';
    } else if (const std::string_view name = entity(character.front()); !name.empty()) {
      out += name;
    } else {
      out += character;
    }
    text.remove_prefix(character.size());
  }
}

}  // namespace panelcal
