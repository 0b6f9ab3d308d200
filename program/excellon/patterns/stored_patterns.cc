// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/stored_patterns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

namespace panelcal::excellon {
namespace {

std::optional<SourceText> read_pattern(const std::string& name,
                                       const std::vector<std::filesystem::path>& folders) {
  constexpr std::array<std::string_view, 4> kExtensions = {"", ".exc", ".drl", ".pat"};
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const std::filesystem::path& folder : folders) {
    for (const std::string& stem : {name, lower}) {
      for (const std::string_view extension : kExtensions) {
        const std::filesystem::path path = folder / (stem + std::string(extension));
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored)) continue;
        if (auto text = read_source_with_digest(path)) return *std::move(text);
      }
    }
  }
  return std::nullopt;
}

}  // namespace

bool is_pattern_name(std::string_view name) {
  constexpr std::string_view kOthers = "?%-$!_.";
  return !name.empty() && name.size() <= 64 && name.front() != '.' &&
         std::ranges::all_of(name, [&](unsigned char c) {
           return std::isalnum(c) != 0 || kOthers.find(static_cast<char>(c)) != kOthers.npos;
         });
}

std::map<std::string, SourceText, std::less<>> read_patterns(
    std::string_view program, const std::vector<std::filesystem::path>& folders) {
  constexpr std::string_view kCall = "M99,";
  std::map<std::string, SourceText, std::less<>> patterns;
  for (auto at = program.find(kCall); at != std::string_view::npos; at = program.find(kCall, at)) {
    at += kCall.size();
    std::string_view name = program.substr(at, program.find_first_of("\r\n", at) - at);
    name = name.substr(0, name.find_last_not_of(" \t") + 1);
    if (!is_pattern_name(name) || patterns.contains(name)) continue;
    if (auto text = read_pattern(std::string(name), folders)) {
      patterns.emplace(name, *std::move(text));
    }
  }
  return patterns;
}

}  // namespace panelcal::excellon
