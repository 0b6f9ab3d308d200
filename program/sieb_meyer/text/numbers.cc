// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/numbers.h"

#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::array<double, 16> kSiebMeyerPowers = {
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// Kinds of quantities that follow the unit of a program in different ways.
enum class Dimension : std::uint8_t {
  None,
  Length,
  Place,  ///< a length that the format's zeros hold for as well
  Rate,   ///< m/min
};

/// Notation of a quantity in a format, in millimetres: value = digits * per_step / 10^n_decimals
/// without a point.
struct Rule {
  double per_step = 1;
  int n_decimals = 0;
  bool has_point = true;
  bool has_sign = false;
  double per_unit = 1;  ///< with a point
  Dimension dimension = Dimension::None;
};

/// Behind the point of a coordinate in millimetres.
int described_decimals(FileFormat format) {
  return format == FileFormat::F1000 ? 2 : 3;
}

Rule rule_of(FileFormat format, Quantity quantity) {
  const bool is_1000 = format == FileFormat::F1000;
  const bool is_5000 = format == FileFormat::F5000;
  switch (quantity) {
    case Quantity::Coordinate:
    case Quantity::ArcParameter:
      return {.n_decimals = described_decimals(format),
              .has_point = !is_1000,
              .has_sign = !is_1000 || quantity == Quantity::Coordinate,
              .dimension = Dimension::Place};
    case Quantity::Plane:
      return {.n_decimals = is_5000 ? 3 : 2, .has_sign = true, .dimension = Dimension::Length};
    case Quantity::RoutFeed:
      return {.n_decimals = is_5000 ? 3 : 1, .has_point = is_5000, .dimension = Dimension::Rate};
    case Quantity::PeckLength:
    case Quantity::ToolZOffset:
      return {.n_decimals = 3,
              .has_sign = quantity == Quantity::ToolZOffset,
              .dimension = Dimension::Length};
    case Quantity::ToolDiameter:
      return {.n_decimals = 2, .has_point = is_5000, .dimension = Dimension::Length};
    case Quantity::ToolFeed:
      return {.n_decimals = 1, .has_point = is_5000, .dimension = Dimension::Rate};
    case Quantity::ToolLife:
      return {.per_step = is_5000 ? 1.0 : 100.0, .has_point = false};
    case Quantity::ToolDwell:
      return {.has_point = is_5000, .per_unit = 1000};
    case Quantity::ToolSpeed:
      return {.has_point = is_5000};
    case Quantity::Percent:
    case Quantity::PerMille:
    case Quantity::Milliseconds:
      return {};
  }
  return {};
}

/// The same in the format of a program; its value is in that one's unit.
Rule rule_of(const ProgramFormat& format, Quantity quantity) {
  Rule rule = rule_of(format.file, quantity);
  switch (rule.dimension) {
    case Dimension::Length:
    case Dimension::Place:
      rule.n_decimals += format.decimal_digits() - described_decimals(format.file);
      break;
    case Dimension::Rate:
      // 0.001 m/min are 1 mm/min, and a step in inch is a tenth of the number in millimetres.
      if (format.unit == LengthUnit::Inch) rule.per_step = 100;
      break;
    case Dimension::None:
      break;
  }
  return rule;
}

/// A unit of the program in that of the quantity's values.
double unit_of(const ProgramFormat& format, Dimension dimension) {
  if (format.unit == LengthUnit::Millimeter || dimension == Dimension::None) return 1;
  const double inch_mm = format.one_unit().in_mm();
  return dimension == Dimension::Rate ? inch_mm / 1000 : inch_mm;
}

}  // namespace

std::string_view name(FileFormat format) {
  switch (format) {
    case FileFormat::F1000:
      return "1000";
    case FileFormat::F3000:
      return "3000";
    case FileFormat::F5000:
      return "5000";
  }
  return "";
}

int ProgramFormat::decimal_digits() const {
  if (digits) return digits->second;
  return described_decimals(file) + (unit == LengthUnit::Inch ? 1 : 0);
}

int ProgramFormat::integer_digits() const {
  if (digits) return digits->first;
  return unit == LengthUnit::Inch ? 2 : 3;
}

double ProgramFormat::step_mm() const {
  const double power = kSiebMeyerPowers.at(static_cast<std::size_t>(decimal_digits()));
  return one_unit().in_mm() * (1 / power);
}

bool ProgramFormat::is_described() const {
  return unit == LengthUnit::Millimeter && zeros == Zeros::TrailingKept &&
         decimal_digits() == described_decimals(file);
}

std::string summary(const ProgramFormat& format) {
  const bool is_inch = format.unit == LengthUnit::Inch;
  std::string text = "format " + std::string(name(format.file)) + (is_inch ? " in inch, " : ", ");
  const int n_decimals = format.decimal_digits();
  if (format.zeros == Zeros::LeadingKept) {
    text += fmt::format("{}.{} digits from the left", format.integer_digits(), n_decimals);
  } else {
    text += fmt::format("{:.{}f} {}", std::pow(10, -n_decimals), n_decimals, format.unit_name());
  }
  return text +
         (format.file == FileFormat::F1000 ? ", no decimal points" : " without a decimal point");
}

ParsedNumber parse_number(std::string_view text, const ProgramFormat& format, Quantity quantity) {
  constexpr std::size_t kMostDigits = 15;
  const Rule rule = rule_of(format, quantity);
  std::size_t i = 0;
  const bool has_sign = !text.empty() && (text[0] == '-' || text[0] == '+');
  const bool is_negative = has_sign && text[0] == '-';
  if (has_sign) ++i;
  std::int64_t digits = 0;
  std::size_t n_digits = 0;
  std::size_t n_decimals = 0;
  bool has_point = false;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.' && !has_point) {
      has_point = true;
      continue;
    }
    if (c < '0' || c > '9') return {.problem = NumberProblem::Malformed};
    if (++n_digits > kMostDigits) return {.problem = NumberProblem::TooLong};
    digits = digits * 10 + (c - '0');
    if (has_point) ++n_decimals;
  }
  if (n_digits == 0 && (has_sign || has_point)) return {.problem = NumberProblem::Malformed};
  if (has_point && !rule.has_point) return {.problem = NumberProblem::PointForbidden};
  if (is_negative && !rule.has_sign) return {.problem = NumberProblem::SignForbidden};
  double factor = has_point ? rule.per_unit : rule.per_step;
  int exponent = has_point ? static_cast<int>(n_decimals) : rule.n_decimals;
  if (!has_point && rule.dimension == Dimension::Place && format.zeros == Zeros::LeadingKept) {
    const int n_most = format.integer_digits() + format.decimal_digits();
    if (static_cast<int>(n_digits) > n_most) return {.problem = NumberProblem::TooManyDigits};
    exponent = static_cast<int>(n_digits) - format.integer_digits();
    if (exponent < 0) {
      factor = kSiebMeyerPowers.at(static_cast<std::size_t>(-exponent));
      exponent = 0;
    }
  }
  const double divisor = kSiebMeyerPowers.at(static_cast<std::size_t>(exponent));
  const double unit = unit_of(format, rule.dimension);
  const double value = static_cast<double>(is_negative ? -digits : digits) * factor / divisor;
  return {.value = unit * value, .step = unit * (factor / divisor)};
}

std::string expectation(NumberProblem problem, const ProgramFormat& format) {
  switch (problem) {
    case NumberProblem::Malformed:
      return "a sign, digits and at most one decimal point";
    case NumberProblem::TooLong:
      return "at most 15 digits";
    case NumberProblem::TooManyDigits:
      return fmt::format("at most {} digits", format.integer_digits() + format.decimal_digits());
    case NumberProblem::PointForbidden:
      return "no decimal point here in format " + std::string(name(format.file));
    case NumberProblem::SignForbidden:
      return "a number that is not negative";
    case NumberProblem::None:
      break;
  }
  return "";
}

}  // namespace panelcal::sieb_meyer
