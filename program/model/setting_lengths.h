// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace panelcal {

/// `Z-.1`: a depth offset without a tool.
inline bool is_depth_offset(std::string_view setting) {
  return setting.size() > 1 && setting[0] == 'Z' &&
         std::string_view("+-.0123456789").find(setting[1]) != setting.npos;
}

/// An Excellon setting with lengths, in the unit of the program: lower and upper limits, distances,
/// peck parameters, a depth offset without a tool. Other settings are switches and counts.
/// Source CNC-7 manual, Inch vs. Metric; Part Program Headers
inline bool has_length(std::string_view setting) {
  constexpr std::array<std::string_view, 4> kLengths = {"DN", "UP", "DTMDIST", "PCKPARAM"};
  const std::string_view word = setting.substr(0, setting.find(','));
  return (is_depth_offset(word) || std::ranges::find(kLengths, word) != kLengths.end()) &&
         setting.find_first_of("0123456789") != setting.npos;
}

/// One whose value depends on the zeros and digits that the program states as well.
inline bool has_bare_length(std::string_view setting) {
  return has_length(setting) && setting.find('.') == setting.npos;
}

}  // namespace panelcal
