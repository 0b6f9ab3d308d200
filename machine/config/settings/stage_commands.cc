// SPDX-License-Identifier: Apache-2.0
#include "machine/config/settings/stage_commands.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "calib/base/diagnostic.h"

namespace panelcal {
namespace {

constexpr std::array<std::string_view, 6> kPlaceholders = {
    "{x}", "{y}", "{z}", "{lamp}", "{zoom}", "{tool}"};

bool contains(const CommandWords& words, std::string_view placeholder) {
  return std::ranges::any_of(
      words, [&](const std::string& word) { return word.find(placeholder) != std::string::npos; });
}

}  // namespace

std::string placeholder_problem(const CommandWords& words, const std::vector<std::string>& wanted) {
  for (const std::string& word : words) {
    for (auto open = word.find('{'); open != std::string::npos; open = word.find('{', open + 1)) {
      const auto close = word.find('}', open);
      if (close == std::string::npos) continue;
      const std::string found = word.substr(open, close + 1 - open);
      if (std::ranges::find(wanted, found) != wanted.end()) continue;
      if (std::ranges::find(kPlaceholders, found) != kPlaceholders.end()) {
        return found + " has no meaning here";
      }
      if (found.find_first_not_of("{}abcdefghijklmnopqrstuvwxyz") == std::string::npos) {
        return "there is no " + quoted(found);
      }
    }
  }
  for (const std::string& placeholder : wanted) {
    if (!contains(words, placeholder)) return placeholder + " is missing";
  }
  return {};
}

}  // namespace panelcal
