// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "program/text/number_format.h"

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

/// The fields of a setting or order that may be lengths: those behind its word. The first one of
/// PCKPARAM is a tool, of CP an index; of G34 only the last one is a length.
inline std::string_view lengths_of(std::string_view setting) {
  const auto comma = setting.find(',');
  if (comma == setting.npos) return setting;
  const std::string_view word = setting.substr(0, comma);
  const std::string_view fields = setting.substr(comma + 1);
  if (word == "G34") return fields.substr(fields.rfind(',') + 1);
  const bool has_number = word == "CP" || word == "PCKPARAM";
  return has_number ? fields.substr(fields.find(',') + 1) : fields;
}

/// One whose value depends on the zeros and digits that the program states as well.
inline bool has_bare_length(std::string_view setting) {
  return has_length(setting) && has_bare_number(lengths_of(setting));
}

}  // namespace panelcal
