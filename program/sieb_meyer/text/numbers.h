// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/units.h"
#include "program/text/number_format.h"

namespace panelcal::sieb_meyer {

/// The three formats that the manual describes: command set, and notation of numbers.
enum class FileFormat : std::uint8_t { F1000, F3000, F5000 };

/// "1000", "3000", "5000".
std::string_view name(FileFormat format);

/// The number format of a program: that of a file format, or one in which the setting of the
/// control or the operator has another unit, other digits or other zeros.
///
/// The manual has tables for millimetres alone and leaves other units to the CNC command FP. The
/// setting has a unit, one resolution and the zeros "of coordinates" (A.1). Read here: every length
/// has the unit; the coordinates' step is 0.0001 inch where it is 0.001 mm (M58 has that pair), and
/// so is that of each length that has the coordinates' step in the tables. What is left has no
/// reading: numbers with another step than coordinates, zeros left off a length that is no
/// coordinate, and rates whose unit nothing states.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 1 Format settings; A.1; B; M58
/// See    tests/program/sieb_meyer/text/inch_numbers_test.cc
struct ProgramFormat {
  FileFormat file = FileFormat::F5000;
  LengthUnit unit = LengthUnit::Millimeter;
  Zeros zeros = Zeros::TrailingKept;
  std::optional<std::pair<int, int>> digits;  ///< before and behind the point; absent: the usual
  std::optional<RateUnit> inch_rates;         ///< of F and R in inch; absent: nothing states it

  constexpr ProgramFormat() = default;
  /// Implicit: each file format has numbers of its own.
  constexpr ProgramFormat(FileFormat format) : file(format) {}

  int integer_digits() const;  ///< of coordinates whose trailing zeros may be left off
  int decimal_digits() const;  ///< of coordinates without a point
  /// The step of the last digit of a coordinate without a decimal point.
  double step_mm() const;
  Length one_unit() const { return unit == LengthUnit::Inch ? inch(1) : mm(1); }
  std::string_view unit_name() const { return unit == LengthUnit::Inch ? "inch" : "mm"; }
  /// Coordinates have the step of the manual's tables.
  bool has_described_step() const;
  /// The numbers are those of the manual's tables.
  bool is_described() const;
};

/// "format 5000, 0.001 mm without a decimal point", "format 5000 in inch, 0.0001 inch without ...".
std::string summary(const ProgramFormat& format);

/// The readings of subprograms, which have no %% of their own, under program and control.
enum class SubprogramNumbers : std::uint8_t {
  OfProgram,         ///< one reading
  OpenWithoutPoint,  ///< the same unit, but other digits or zeros
  Open,
};

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

enum class NumberProblem : std::uint8_t {
  None,
  Malformed,
  TooLong,
  TooManyDigits,
  PointForbidden,
  SignForbidden,
  StepOpen,   ///< without a point: of another step than coordinates
  ZerosOpen,  ///< without a point, with zeros left off
  RateOpen,   ///< in inch/min or m/min
};

/// The number is well-formed, but nothing states what it means.
constexpr bool is_open(NumberProblem problem) {
  return problem >= NumberProblem::StepOpen;
}

struct ParsedNumber {
  double value = 0;
  NumberProblem problem = NumberProblem::None;
  double step = 0;  ///< of one in the last digit
};

/// Reads `[+-]digits[.digits]`; no digits at all are zero. Without a decimal point the number
/// counts the format's steps, with one it is in the quantity's unit. The value is in the unit that
/// Quantity names, whatever that of the format is.
///
/// Fails  PointForbidden and SignForbidden where the format has none; TooLong above 15 digits, from
///        where on a double would round; TooManyDigits where digits count from the left; StepOpen,
///        ZerosOpen and RateOpen where the digits have no stated meaning
/// Source SIEB & MEYER CNC 8x.00 Command Set, units at each command; appendix A
/// See    tests/program/sieb_meyer/text/numbers_test.cc
ParsedNumber parse_number(std::string_view text, const ProgramFormat& format, Quantity quantity);

/// The remedy, for messages.
std::string expectation(NumberProblem problem,
                        const ProgramFormat& format,
                        Quantity quantity = Quantity::Coordinate);

}  // namespace panelcal::sieb_meyer
