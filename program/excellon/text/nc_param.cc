// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/nc_param.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "program/text/gaps.h"

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

}  // namespace

Expected<FormatBeside> read_nc_param(const SourceText& source) {
  std::array<std::optional<int>, kKeys.size()> values;
  for (LineCursor cursor(source.bytes); !cursor.at_end();) {
    const SourceLine line = cursor.next();
    const std::string_view text = trimmed(line.text);
    const std::string_view word = text.substr(0, text.find_first_of(" \t"));
    for (std::size_t key = 0; key < kKeys.size(); ++key) {
      if (word != kKeys.at(key)) continue;
      const std::string_view value = trimmed(text.substr(word.size()));
      std::optional<int>& known = values.at(key);
      const bool is_again = known.has_value();
      known = value_of(key, value);
      if (known && !is_again) continue;
      return failure({Code::ArgumentInvalid,
                      {source.file, line.number, 1},
                      quoted(text),
                      std::string(is_again ? "each line once" : expected_of(key))});
    }
  }
  FormatBeside beside;
  beside.file = source.file;
  PartialFormat& format = beside.format;
  if (values[kUnits])
    format.unit = *values[kUnits] == 0 ? LengthUnit::Inch : LengthUnit::Millimeter;
  if (values[kBefore] && values[kBehind]) format.digits.emplace(*values[kBefore], *values[kBehind]);
  const bool leaves_leading = values[kLeading] == 1;
  const bool leaves_trailing = values[kTrailing] == 1;
  if (leaves_leading != leaves_trailing) {
    format.zeros = leaves_leading ? Zeros::TrailingKept : Zeros::LeadingKept;
  }
  if (!format.is_empty()) format.from = source.file;
  if (values[kCoordinates]) beside.is_incremental = *values[kCoordinates] == 1;
  return beside;
}

}  // namespace panelcal::excellon
