// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/units.h"
#include <tl/expected.hpp>

namespace panelcal {

enum class LengthUnit : std::uint8_t { Inch, Millimeter };

/// Zeros that a number without a decimal point keeps.
enum class Zeros : std::uint8_t {
  LeadingKept,   ///< LZ: digits count from the left, trailing zeros may be left off
  TrailingKept,  ///< TZ: digits count from the right, leading zeros may be left off
};

/// The unit of F and R, the rates of SIEB & MEYER programs: their tables have the first alone.
enum class RateUnit : std::uint8_t { MetersPerMinute, InchesPerMinute };

/// Notation of a program's lengths (CNC-7 manual, Inch vs. Metric; Leading and Trailing Zeros). The
/// default is the manual's: inch, two digits before and four behind the point, leading zeros.
struct NumberFormat {
  LengthUnit unit = LengthUnit::Inch;
  Zeros zeros = Zeros::LeadingKept;
  /// The digit counts are stated, not taken for granted: then a number that counts from the right
  /// has one reading however many zeros stand to its left.
  bool states_digits = false;
  int integer_digits = 2;
  int decimal_digits = 4;

  bool operator==(const NumberFormat&) const = default;

  /// Those of the unit: two and four in inch, three and three in metric.
  void take_usual_digits();
  Length one_unit() const { return unit == LengthUnit::Inch ? inch(1) : mm(1); }
  /// "inch 2.4, leading zeros kept".
  std::string summary() const;
  /// "inch,lz,2.4", as --format takes it.
  std::string option() const;
  /// "00.0000".
  std::string digit_mask() const;
  /// "INCH,LZ,00.0000", as an Excellon header states it.
  std::string header_word() const;
};

/// True if the two give every number without a decimal point that both can read the same value in
/// their units.
bool are_scaled_alike(const NumberFormat& a, const NumberFormat& b);

/// A number format as far as one source states it: a line of the program, the control's last
/// setting, the operator.
struct PartialFormat {
  std::optional<LengthUnit> unit;
  std::optional<Zeros> zeros;
  std::optional<std::pair<int, int>> digits;  ///< before and behind the point
  std::string from;                           ///< its source, for people

  bool is_empty() const { return !unit && !zeros && !digits; }
};

/// Reads `inch,tz,2.4`: a unit (inch, metric, mm), kept zeros (lz, tz) and digits before and behind
/// the point, each at most once, in any order, in small or capital letters.
///
/// Fails  with what was expected
tl::expected<PartialFormat, std::string> parse_format(std::string_view text);
/// The parts of it.
std::optional<LengthUnit> parse_unit(std::string_view text);
std::optional<Zeros> parse_zeros(std::string_view text);
/// `m/min` or `inch/min`.
std::optional<RateUnit> parse_rate_unit(std::string_view text);
/// `2.4`: one to six digits on either side.
std::optional<std::pair<int, int>> parse_digits(std::string_view text);

enum class NumberFault : std::uint8_t { None, Malformed, TooManyDigits };

struct ParsedLength {
  Length value;
  NumberFault fault = NumberFault::None;
};

/// Reads `[+-]digits[.digits]`; no digits at all mean zero (the manual's `XY`). A decimal point
/// overrides the format's zeros and digit counts. Zeros to the left of a number that counts from
/// the right may exceed the digits, if these are stated.
ParsedLength parse_length(std::string_view text, const NumberFormat& format);

/// True for a number without a decimal point that has more digits than the format. Where
/// parse_length() reads it, the digits beyond the format's are zeros.
bool has_extra_digits(std::string_view number, const NumberFormat& format);

/// True for a number whose value depends on the zeros and digits of the format: one without a
/// decimal point, and not 0.
bool is_bare(std::string_view number);
/// True for a text of several numbers, one of which is.
bool has_bare_number(std::string_view text);

/// Digits of an unsigned whole number below 10^9; empty for anything else.
std::optional<int> parse_count(std::string_view text);

}  // namespace panelcal
