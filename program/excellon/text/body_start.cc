// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/body_start.h"

#include <optional>
#include <utility>

#include "program/excellon/text/header_words.h"
#include "program/model/setting_lengths.h"
#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

std::optional<BodyUnit> read_body_unit(std::string_view text,
                                       int line,
                                       std::string_view inch_code) {
  const HeaderCommand command = split_header_command(text);
  const bool is_code = command.word == "M71" || command.word == inch_code;
  if (!is_code && command.word != "INCH" && command.word != "METRIC") return std::nullopt;
  const bool is_inch = command.word == inch_code || command.word == "INCH";
  BodyUnit found{.line = line, .text = text};
  found.format.unit = is_inch ? LengthUnit::Inch : LengthUnit::Millimeter;
  found.format.from = fmt::format("line {}: {}", line, text);
  if (is_code) return found;
  found.form = StatedFormat::Form::Word;
  const auto statement = unit_statement(command);
  // The body has no digits: such a line is refused when it is executed.
  if (statement && !statement->digits) found.format.zeros = statement->zeros;
  return found;
}

}  // namespace

BodyStart read_body_start(LineCursor body, ProgramSet set) {
  const std::string_view inch_code = set == ProgramSet::FormatOne ? "M70" : "M72";
  BodyStart start;
  while (!body.at_end()) {
    const SourceLine line = body.next();
    const std::string_view text = trimmed(line.text);
    if (text.empty() || text.front() == ';') continue;
    if (text.front() == 'X' || text.front() == 'Y' || has_length(text)) break;
    if (is_long_message(text)) {
      skip_message(body, text);
      continue;
    }
    start.states_steps |= text.starts_with("G90") || text.starts_with("G91") ||
                          split_header_command(text).word == "ICI";
    if (auto unit = read_body_unit(text, line.number, inch_code)) {
      start.units.push_back(*std::move(unit));
    }
  }
  return start;
}

}  // namespace panelcal::excellon
