// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "program/text/number_format.h"
#include <fmt/format.h>

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

/// A setting of either language whose text may have lengths: those above, CP, ZC, CAN_TEXT_OFF,
/// G39, orders of the camera, M49. An output whose lengths are mm states the unit of its text.
inline bool may_have_length(std::string_view setting) {
  constexpr std::array<std::string_view, 7> kBegins = {
      "CP,", "ZC,", "CAN_TEXT_OFF", "G39", "$uvis,searcharea", "$uvis,focus", "M49,"};
  const auto begins = [&](std::string_view word) { return setting.starts_with(word); };
  const auto comma = setting.find(',');
  const std::string_view fields = comma == setting.npos ? setting : setting.substr(comma);
  return (has_length(setting) || std::ranges::any_of(kBegins, begins)) &&
         fields.find_first_of("0123456789") != fields.npos;
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

/// The setting with each number among its lengths as `rewrite` has it.
///
/// In     rewrite: a number as written to its new text; absent: it cannot be rewritten
/// Fails  absent: one of the numbers cannot
template <class Rewrite>
std::optional<std::string> with_lengths(std::string_view setting, Rewrite&& rewrite) {
  constexpr std::string_view kNumber = ".0123456789";
  std::string_view rest = lengths_of(setting);
  std::string text(setting.substr(0, setting.size() - rest.size()));
  while (!rest.empty()) {
    const auto n_other = std::min(rest.find_first_of(kNumber), rest.size());
    text += rest.substr(0, n_other);
    rest.remove_prefix(n_other);
    const std::string_view number = rest.substr(0, rest.find_first_not_of(kNumber));
    rest.remove_prefix(number.size());
    const std::optional<std::string> rewritten = rewrite(number);
    if (!rewritten) return std::nullopt;
    text += *rewritten;
  }
  return text;
}

/// The setting with a decimal point in each of its lengths, so that no digits decide on them.
///
/// In     format: that of its numbers
/// Fails  absent: the format cannot read one of them
inline std::optional<std::string> with_points(std::string_view setting,
                                              const NumberFormat& format) {
  return with_lengths(setting, [&](std::string_view number) -> std::optional<std::string> {
    if (!is_bare(number)) return std::string(number);
    const ParsedLength parsed = parse_length(number, format);
    if (parsed.fault != NumberFault::None) return std::nullopt;
    // Six digits behind the point are the most of any format.
    std::string pointed = fmt::format("{:.6f}", parsed.value / format.one_unit());
    pointed.resize(std::max(pointed.find_last_not_of('0') + 1, pointed.find('.') + 2));
    return pointed;
  });
}

/// True if a number of the text has more decimals than that.
inline bool has_more_decimals(std::string_view text, int n_decimals) {
  constexpr std::string_view kDigits = "0123456789";
  for (auto at = text.find('.'); at != text.npos; at = text.find('.', at + 1)) {
    const auto end = std::min(text.find_first_not_of(kDigits, at + 1), text.size());
    if (end - at - 1 > static_cast<std::size_t>(n_decimals)) return true;
  }
  return false;
}

/// The setting with its lengths rounded to that many decimals, where one of them has more.
///
/// In     setting: Excellon's, with a decimal point in each length that has decimals
inline std::string with_decimals(std::string_view setting, int n_decimals) {
  const bool is_length = has_length(setting) || setting.starts_with("CP,");
  if (!is_length) return std::string(setting);
  const auto rounded = [&](std::string_view number) -> std::optional<std::string> {
    if (!has_more_decimals(number, n_decimals)) return std::string(number);
    double value = 0;
    std::from_chars(number.data(), number.data() + number.size(), value, std::chars_format::fixed);
    return fmt::format("{:.{}f}", value, n_decimals);
  };
  return *with_lengths(setting, rounded);
}

}  // namespace panelcal
