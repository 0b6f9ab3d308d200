// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "program/text/number_format.h"

namespace panelcal::sieb_meyer {

/// The three formats that the manual describes; the fourth digit of their names is left out, since
/// the formats xx01 to xx10 are no part of it.
enum class FileFormat : std::uint8_t { F1000, F3000, F5000 };

/// "1000", "3000", "5000".
std::string_view name(FileFormat format);
/// "format 5000, 0.001 mm without a decimal point".
std::string summary(FileFormat format);

/// The step of the last digit of a coordinate without a decimal point.
constexpr double format_step_mm(FileFormat format) {
  return format == FileFormat::F1000 ? 0.01 : 0.001;
}

/// The quantity of a number; the unit of its value.
enum class Quantity : std::uint8_t {
  Coordinate,    ///< X Y, mm
  ArcParameter,  ///< R I J D of contours, mm
  Plane,         ///< H K Z, mm
  RoutFeed,      ///< F, m/min
  PeckLength,    ///< I J R of G81 and G89, mm
  Percent,       ///< P
  PerMille,      ///< W of G81
  Milliseconds,  ///< E
  ToolDiameter,  ///< D of the tool table, mm
  ToolSpeed,     ///< S, 1000 rpm
  ToolFeed,      ///< F and R, m/min
  ToolLife,      ///< N, strokes
  ToolDwell,     ///< A, ms
  ToolZOffset,   ///< Z of the tool table, mm
};

enum class NumberProblem : std::uint8_t { None, Malformed, TooLong, PointForbidden, SignForbidden };

struct ParsedNumber {
  double value = 0;
  NumberProblem problem = NumberProblem::None;
  double step = 0;  ///< of one in the last digit
};

/// Reads `[+-]digits[.digits]`; no digits at all are zero. Without a decimal point the number
/// counts the format's steps, with one it is in the quantity's unit.
///
/// Fails  PointForbidden and SignForbidden where the format has none; TooLong above 15 digits, from
///        where on a double would round
/// Source SIEB & MEYER CNC 8x.00 Command Set, units at each command; appendix A
/// See    tests/program/sieb_meyer/text/numbers_test.cc
ParsedNumber parse_number(std::string_view text, FileFormat format, Quantity quantity);

/// The remedy, for messages.
std::string expectation(NumberProblem problem, FileFormat format);

}  // namespace panelcal::sieb_meyer
