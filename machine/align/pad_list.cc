// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "machine/align/pad_readers.h"

namespace panelcal::internal {
namespace {

std::optional<double> list_number(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return std::nullopt;
  return decimal_of(text.substr(begin, text.find_last_not_of(' ') + 1 - begin));
}

}  // namespace

std::optional<double> decimal_of(std::string_view text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool is_pad_list(std::string_view text) {
  return text.find(',') != std::string_view::npos &&
         text.find_first_not_of("0123456789+-.,; eE") == std::string_view::npos;
}

Expected<FoundPads> pads_of_list(std::string_view text) {
  FoundPads found;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(';'));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    const auto comma = part.find(',');
    const auto x = list_number(part.substr(0, comma));
    const auto y = comma == std::string_view::npos ? x : list_number(part.substr(comma + 1));
    const int number = static_cast<int>(found.pads.size()) + 1;
    if (comma == std::string_view::npos || !x || !y) {
      return failure({Code::Usage,
                      {"PADS", number, 0},
                      quoted(part),
                      "X,Y;X,Y in mm, such as 5,5;95,5;95,75"});
    }
    found.pads.push_back(
        {{.nominal = position_mm<frame::Nominal>(*x, *y), .line = number}, std::nullopt});
  }
  return found;
}

}  // namespace panelcal::internal
