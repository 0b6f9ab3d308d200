// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/recognition.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <string>

namespace panelcal::gcode {
namespace {

constexpr int kLookedAt = 2000;
/// G-words of rs274 and of controllers like it that Excellon does not have.
constexpr std::array kForeignWords = {17, 18, 19, 20, 21, 28, 43, 49, 53, 54,
                                      55, 56, 57, 58, 59, 61, 64, 80, 92, 94};

struct SeenWords {
  bool is_foreign = false;
  bool has_z = false;
  bool has_tool = false;
};

/// Comments, in brackets or to the end of the line, do not count.
std::string without_comments(std::string_view line) {
  std::string text;
  bool is_comment = false;
  for (const char c : line) {
    if (c == ';') break;
    if (c == '(') is_comment = true;
    if (!is_comment && c != ' ' && c != '\t') {
      text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    }
    if (c == ')') is_comment = false;
  }
  return text;
}

SeenWords words_of(std::string_view text) {
  SeenWords seen;
  for (std::size_t at = 0; at < text.size();) {
    const char letter = text[at++];
    double number = 0;
    const char* const begin = text.data() + at;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
    // Whatever is no letter with a number is not of either language.
    if (letter < 'A' || letter > 'Z' || error != std::errc()) return {};
    at += static_cast<std::size_t>(end - begin);
    seen.is_foreign |=
        letter == 'G' && std::ranges::find(kForeignWords, number) != kForeignWords.end();
    seen.has_z |= letter == 'Z';
    seen.has_tool |= letter == 'T';
  }
  return seen;
}

}  // namespace

std::optional<SourceLine> line_of_gcode(std::string_view bytes) {
  std::optional<SourceLine> first;
  bool moves_z = false;
  LineCursor cursor(bytes);
  for (int i = 0; i < kLookedAt && !cursor.at_end(); ++i) {
    const SourceLine line = cursor.next();
    const std::string text = without_comments(line.text);
    if (text == "M48") return std::nullopt;
    const SeenWords seen = words_of(text);
    if (seen.is_foreign && !first) first = line;
    // Excellon's Z is the offset of a tool, or of a step slot.
    moves_z |= seen.has_z && !seen.has_tool && text.find("G87") == text.npos;
    if (first && moves_z) return first;
  }
  return std::nullopt;
}

}  // namespace panelcal::gcode
