// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

/// Bytes of the UTF-8 character `text` begins with; 0 if it begins with none that HTML may hold
/// (broken sequences, overlong ones, surrogates, control characters).
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  std::uint32_t character = first & (0xffU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
    character = (character << 6) | (byte(i) & 0x3fU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0xa0, 0x800, 0x10000};
  const bool is_surrogate = character >= 0xd800 && character <= 0xdfff;
  const bool is_no_character = (character & 0xfffeU) == 0xfffe;
  // Characters that turn the direction of writing could make a name look like another one.
  const bool is_bidi =
      (character >= 0x202a && character <= 0x202e) || (character >= 0x2066 && character <= 0x2069);
  const bool is_bad = character < kLeast[length] || character > 0x10ffff || is_surrogate ||
                      is_no_character || is_bidi;
  return is_bad ? 0 : length;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    std::size_t length = 1;
    switch (text.front()) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '\n':
      case '\t':
        out += ' ';
        break;
      default:
        length = character_length(text);
        if (length > 0) {
          out += text.substr(0, length);
        } else {
          length = 1;
          internal::append_format(out, "\\x{:02x}", static_cast<unsigned char>(text.front()));
        }
    }
    text.remove_prefix(length);
  }
  return out;
}

std::string fixed_signed(double value, int n_decimals) {
  const std::string text = fixed(value, n_decimals);
  return std::isnan(value) || text.starts_with('-') ? text : "+" + text;
}

std::string with_sigma(double value, double sigma, std::string_view unit, bool is_signed) {
  int n_decimals = 3;
  if (std::isfinite(sigma) && sigma > 0) {
    n_decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 6);
  }
  return fmt::format("{} &#177; {} {}",
                     is_signed ? fixed_signed(value, n_decimals) : fixed(value, n_decimals),
                     fixed(sigma, n_decimals),
                     unit);
}

std::string point_text(const Eigen::Vector2d& p_mm) {
  return fmt::format("({}, {})", fixed(p_mm.x(), 3), fixed(p_mm.y(), 3));
}

std::string path_text(std::span<const int> path) {
  return path.empty() ? std::string() : fmt::format("[{}]", fmt::join(path, ","));
}

}  // namespace panelcal::report
