// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/nc_param.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

constexpr std::array<std::string_view, 6> kKeys = {"OUTPUT-UNITS",
                                                   "INTEGER-PLACES",
                                                   "DECIMAL-PLACES",
                                                   "SUPPRESS-LEAD-ZEROES",
                                                   "SUPPRESS-TRAIL-ZEROES",
                                                   "COORDINATES"};
enum Key : std::size_t { kUnits, kBefore, kBehind, kLeading, kTrailing, kCoordinates };

std::string_view expected_of(std::size_t key) {
  if (key == kUnits) return "ENGLISH or METRIC";
  if (key == kCoordinates) return "ABSOLUTE or INCREMENTAL";
  return key == kBefore || key == kBehind ? "1 to 6" : "YES or NO";
}

/// The value as a number: of two words the second is 1.
std::optional<int> value_of(std::size_t key, std::string_view text) {
  if (key == kUnits) {
    if (text == "ENGLISH" || text == "INCHES" || text == "INCH") return 0;
    return text == "METRIC" ? std::optional(1) : std::nullopt;
  }
  if (key == kCoordinates) {
    if (text == "ABSOLUTE") return 0;
    return text == "INCREMENTAL" ? std::optional(1) : std::nullopt;
  }
  if (key == kLeading || key == kTrailing) {
    if (text == "NO") return 0;
    return text == "YES" ? std::optional(1) : std::nullopt;
  }
  const std::optional<int> n = parse_count(text);
  return n && *n >= 1 && *n <= 6 ? n : std::nullopt;
}

/// SUPPRESS-LEADING-ZEROS, which the editor does not write: it might be meant.
bool is_about_zeros(std::string_view word) {
  return word.starts_with("SUPPRESS-") && word.find("ZERO") != std::string_view::npos;
}

}  // namespace

Expected<FormatBeside> read_nc_param(const SourceText& source) {
  std::array<std::optional<int>, kKeys.size()> values;
  std::array<SourceLine, kKeys.size()> lines;
  const auto problem = [&](Code code, const SourceLine& line, std::string why, std::string remedy) {
    return Diagnostic{
        code, {source.file, line.number, 1}, quoted(trimmed(line.text)) + why, std::move(remedy)};
  };
  for (LineCursor cursor(source.bytes); !cursor.at_end();) {
    const SourceLine line = cursor.next();
    const std::string_view text = trimmed(line.text);
    const std::string_view word = text.substr(0, text.find_first_of(" \t"));
    const auto found = std::ranges::find(kKeys, word);
    if (found == kKeys.end()) {
      if (!is_about_zeros(word)) continue;
      return failure(problem(Code::ArgumentInvalid,
                             line,
                             "",
                             fmt::format("{} or {}", kKeys[kLeading], kKeys[kTrailing])));
    }
    const auto key = static_cast<std::size_t>(found - kKeys.begin());
    std::optional<int>& known = values.at(key);
    const bool is_again = known.has_value();
    known = value_of(key, trimmed(text.substr(word.size())));
    if (!known || is_again) {
      return failure(problem(Code::ArgumentInvalid,
                             line,
                             "",
                             std::string(is_again ? "each line once" : expected_of(key))));
    }
    lines.at(key) = line;
  }
  if (values[kBefore].has_value() != values[kBehind].has_value()) {
    return failure(problem(Code::ArgumentInvalid,
                           lines.at(values[kBefore] ? kBefore : kBehind),
                           " alone",
                           "INTEGER-PLACES and DECIMAL-PLACES"));
  }
  FormatBeside beside;
  beside.file = source.file;
  PartialFormat& format = beside.format;
  if (values[kUnits])
    format.unit = *values[kUnits] == 0 ? LengthUnit::Inch : LengthUnit::Millimeter;
  if (values[kBefore]) format.digits.emplace(*values[kBefore], *values[kBehind]);
  const bool leaves_leading = values[kLeading] == 1;
  const bool leaves_trailing = values[kTrailing] == 1;
  if (leaves_leading != leaves_trailing) {
    format.zeros = leaves_leading ? Zeros::TrailingKept : Zeros::LeadingKept;
  }
  if (!format.is_empty()) format.from = source.file;
  if (values[kCoordinates] == 1) {
    beside.steps = problem(Code::NotSupported,
                           lines.at(kCoordinates),
                           " of a program that does not say so",
                           "ICI, G90 or G91 ahead of the program's first coordinate");
  }
  return beside;
}

}  // namespace panelcal::excellon
