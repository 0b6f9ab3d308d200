// SPDX-License-Identifier: Apache-2.0
// Reads pages as far as tests need it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace panelcal::test {

inline std::size_t count(std::string_view text, std::string_view what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// The values of all attributes `name`.
inline std::vector<std::string> attributes(std::string_view html, const std::string& name) {
  std::vector<std::string> values;
  const std::string begin = " " + name + "=\"";
  for (auto at = html.find(begin); at != std::string_view::npos; at = html.find(begin, at + 1)) {
    const auto first = at + begin.size();
    values.emplace_back(html.substr(first, html.find('"', first) - first));
  }
  return values;
}

inline std::optional<std::string> decoded_base64(std::string_view text) {
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (text.size() % 4 != 0) return std::nullopt;
  std::size_t n_padding = 0;
  while (n_padding < 2 && text.ends_with('=')) {
    text.remove_suffix(1);
    ++n_padding;
  }
  std::string bytes;
  std::uint32_t bits = 0;
  int n_bits = 0;
  for (const char c : text) {
    const auto value = kAlphabet.find(c);
    if (value == std::string_view::npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    n_bits += 6;
    if (n_bits >= 8) {
      n_bits -= 8;
      bytes += static_cast<char>(bits >> n_bits & 0xffU);
    }
  }
  return bytes;
}

/// Empty if all that follows the tag's name is name="value".
inline std::string attribute_problem(std::string_view tag) {
  auto at = tag.find_first_of(" \n");
  while (at != std::string_view::npos) {
    const auto first = tag.find_first_not_of(" \n", at);
    if (first == std::string_view::npos || tag.substr(first) == "/") return "";
    const auto equals = tag.find_first_not_of("abcdefghijklmnopqrstuvwxyzB-", first);
    if (equals == std::string_view::npos || tag.substr(equals, 2) != "=\"") break;
    const auto end = tag.find('"', equals + 2);
    if (end == std::string_view::npos) break;
    at = end + 1;
    if (at == tag.size()) return "";
    if (tag[at] != ' ' && tag[at] != '\n' && tag[at] != '/') break;
    if (tag[at] == '/') return at + 1 == tag.size() ? "" : "stray /";
  }
  return at == std::string_view::npos ? "" : "bad attributes: " + std::string(tag.substr(0, 60));
}

/// Empty if every tag is closed in order, every attribute quoted and every & an entity; else what
/// is wrong.
inline std::string markup_problem(std::string_view html) {
  std::vector<std::string> open;
  for (auto at = html.find('&'); at != std::string_view::npos; at = html.find('&', at + 1)) {
    const auto end = html.find_first_not_of("#abcdefghijklmnopqrstuvwxyz0123456789", at + 1);
    if (end == std::string_view::npos || html[end] != ';') {
      return "stray & in " + std::string(html.substr(at, 20));
    }
  }
  for (auto at = html.find('<'); at != std::string_view::npos; at = html.find('<', at + 1)) {
    const auto end = html.find('>', at);
    if (end == std::string_view::npos) return "unclosed <";
    std::string_view tag = html.substr(at + 1, end - at - 1);
    if (tag.starts_with('!')) continue;
    if (tag.find('<') != std::string_view::npos) return "< in tag " + std::string(tag);
    if (const std::string problem = attribute_problem(tag); !problem.empty()) return problem;
    const bool is_end = tag.starts_with('/');
    if (is_end) tag.remove_prefix(1);
    const std::string name(tag.substr(0, tag.find_first_of(" \n/")));
    if (tag.ends_with('/')) continue;
    if (!is_end) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "never closed: " + open.back();
}

}  // namespace panelcal::test
