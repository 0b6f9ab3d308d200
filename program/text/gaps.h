// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// True for a character that only parts words of a line.
constexpr bool is_gap(char c) {
  return c == ' ' || c == '\t';
}

/// The text without gaps at either end.
constexpr std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_gap(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_gap(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace panelcal
