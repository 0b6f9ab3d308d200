// SPDX-License-Identifier: Apache-2.0
#include "surface/files/formats/json_places.h"

#include <algorithm>
#include <cstddef>

namespace panelcal::internal {
namespace {

constexpr std::string_view kJsonBlanks = " \t\r\n";

std::string_view without_blanks(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(kJsonBlanks), text.size());
  return text.substr(begin, text.find_last_not_of(kJsonBlanks) + 1 - begin);
}

/// Where a part of an object or array ends: at a comma or colon of its own level, or its end.
std::size_t end_of_part(std::string_view text, std::size_t begin) {
  int depth = 0;
  for (std::size_t i = begin; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      for (++i; i < text.size() && text[i] != '"'; ++i) i += text[i] == '\\' ? 1 : 0;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (depth == 0 && (c == ',' || c == ':')) {
      return i;
    }
  }
  return text.size();
}

/// What stands between the brackets of a value, parted by commas and colons.
std::vector<std::string_view> parts_of(std::string_view value, char bracket) {
  if (!value.starts_with(bracket) || value.size() < 2) return {};
  const std::string_view inner = without_blanks(value.substr(1, value.size() - 2));
  std::vector<std::string_view> out;
  for (std::size_t begin = 0; begin < inner.size();) {
    const std::size_t end = end_of_part(inner, begin);
    out.push_back(without_blanks(inner.substr(begin, end - begin)));
    begin = end + 1;
  }
  return out;
}

}  // namespace

JsonPlaces::JsonPlaces(std::string_view text) : text_(text), line_starts_{0} {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') line_starts_.push_back(i + 1);
  }
}

TextField JsonPlaces::field(std::string_view value) const {
  if (value.empty()) return {value, 1, 1};
  const auto at = static_cast<std::size_t>(value.data() - text_.data());
  const auto next = std::ranges::upper_bound(line_starts_, at);
  return {value,
          static_cast<int>(next - line_starts_.begin()),
          static_cast<int>(at - *std::prev(next)) + 1};
}

std::string_view JsonPlaces::document() const {
  return without_blanks(text_);
}

std::vector<std::pair<std::string_view, std::string_view>> JsonPlaces::members(
    std::string_view object) {
  const auto parts = parts_of(object, '{');
  std::vector<std::pair<std::string_view, std::string_view>> out;
  for (std::size_t i = 0; i + 1 < parts.size(); i += 2) {
    out.emplace_back(parts[i].substr(1, parts[i].size() - 2), parts[i + 1]);
  }
  return out;
}

std::vector<std::string_view> JsonPlaces::elements(std::string_view array) {
  return parts_of(array, '[');
}

std::string_view JsonPlaces::member(std::string_view object, std::string_view key) {
  for (const auto& [name, value] : members(object)) {
    if (name == key) return value;
  }
  return {};
}

}  // namespace panelcal::internal
