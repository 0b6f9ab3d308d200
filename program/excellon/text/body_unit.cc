// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/body_unit.h"

#include "program/excellon/text/header_words.h"
#include "program/model/setting_lengths.h"
#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal::excellon {

std::optional<BodyUnit> find_body_unit(LineCursor body, ProgramSet set) {
  const std::string_view inch_code = set == ProgramSet::FormatOne ? "M70" : "M72";
  while (!body.at_end()) {
    const SourceLine line = body.next();
    const std::string_view text = trimmed(line.text);
    if (text.empty() || text.front() == ';') continue;
    if (text.front() == 'X' || text.front() == 'Y' || has_length(text)) return std::nullopt;
    if (is_long_message(text)) {
      skip_message(body, text);
      continue;
    }
    const auto [word, value] = split_header_command(text);
    const bool is_inch = word == "INCH" || word == inch_code;
    if (!is_inch && word != "METRIC" && word != "M71") continue;
    BodyUnit found{line.number, text, {}};
    found.format.unit = is_inch ? LengthUnit::Inch : LengthUnit::Millimeter;
    found.format.from = fmt::format("line {}: {}", line.number, text);
    const std::optional<FormatWords> words = read_format_words(value);
    if (words && !words->digits) found.format.zeros = words->zeros;
    return found;
  }
  return std::nullopt;
}

}  // namespace panelcal::excellon
