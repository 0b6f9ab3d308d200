// SPDX-License-Identifier: Apache-2.0
#include "program/text/decimal_points.h"

#include <cstddef>

namespace panelcal {
namespace {

/// The letter before a point, behind the digits and the sign that stand between.
char letter_before(std::string_view program, std::size_t point) {
  while (point > 0) {
    const char c = program[--point];
    const bool is_number = (c >= '0' && c <= '9') || c == '+' || c == '-';
    if (!is_number) return c;
  }
  return '\0';
}

bool is_in_comment(std::string_view program, std::size_t at) {
  const auto line_end = program.find_last_of("\r\n", at);
  const std::size_t begin = line_end == std::string_view::npos ? 0 : line_end + 1;
  return program.substr(begin, at - begin).find_first_of(";(") != std::string_view::npos;
}

}  // namespace

bool has_decimal_coordinates(std::string_view program) {
  for (auto at = program.find('.'); at != std::string_view::npos; at = program.find('.', at + 1)) {
    const char letter = letter_before(program, at);
    if (letter != 'X' && letter != 'Y') continue;
    if (!is_in_comment(program, at)) return true;
    at = program.find_first_of("\r\n", at);  // each line is walked back once
    if (at == std::string_view::npos) break;
  }
  return false;
}

}  // namespace panelcal
