// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/http/message.h"

#include <algorithm>

namespace panelcal::serve {
namespace {

char small_letter(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_same_name(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, {}, small_letter, small_letter);
}

}  // namespace

std::string_view Request::header(std::string_view name) const {
  for (const Header& header : headers) {
    if (is_same_name(header.name, name)) return header.value;
  }
  return {};
}

std::size_t Request::n_headers(std::string_view name) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      headers, [&](const Header& header) { return is_same_name(header.name, name); }));
}

}  // namespace panelcal::serve
