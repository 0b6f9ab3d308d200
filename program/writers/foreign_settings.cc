// SPDX-License-Identifier: Apache-2.0
#include "program/writers/foreign_settings.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "program/sieb_meyer/figures/drill_patterns.h"
#include "program/sieb_meyer/text/cnc_commands.h"

namespace panelcal {
namespace {

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

}  // namespace

std::string_view setting_key(std::string_view text) {
  return text.substr(0, text.find_first_of(", \t"));
}

bool is_left_to_vision(std::string_view text) {
  constexpr std::array<std::string_view, 4> kOrders = {
      "M75", "$uvis,auto,", "$uvis,entry,", "$uvis,box,"};
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return std::ranges::any_of(kOrders,
                             [&](std::string_view order) { return text.starts_with(order); });
}

bool is_spelling(std::string_view key) {
  constexpr std::array<std::string_view, 16> kSpelling = {"FMAT",
                                                          "METRIC",
                                                          "INCH",
                                                          "M71",
                                                          "M72",
                                                          "G05",
                                                          "G07",
                                                          "G90",
                                                          "G91",
                                                          "ICI",
                                                          "ICI,OFF",
                                                          "OM48",
                                                          "BLKD",
                                                          "CP",
                                                          "CAN_TEXT_OFF",
                                                          "VER"};
  return contains(kSpelling, key);
}

bool decides_places(std::string_view key) {
  return key == "ZC" || key == "DN" || (key.size() > 1 && key.front() == 'Z' && key != "ZC");
}

bool is_obeyed(std::string_view command) {
  constexpr std::array<std::string_view, 4> kModes = {"CAMA", "NOCAMA", "FA", "NOFA"};
  return command.starts_with("FV") || contains(kModes, command) || command.starts_with("FAX") ||
         command.starts_with("FAY");
}

bool is_initial(std::string_view command, LengthUnit unit) {
  constexpr std::string_view kRoughness = "NIB";
  if (command == "NONIBO") return true;
  if (!command.starts_with(kRoughness) || unit != LengthUnit::Millimeter) return false;
  return sieb_meyer::read_plain_number(command.substr(kRoughness.size())) ==
         sieb_meyer::Nibbling{}.roughness_mm;
}

}  // namespace panelcal
