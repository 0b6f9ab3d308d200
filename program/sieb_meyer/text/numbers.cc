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

/// Behind the point of a coordinate in millimetres.
constexpr int described_decimals(FileFormat format) {
  return format == FileFormat::F1000 ? 2 : 3;
}

/// Kinds of quantities that follow the unit of a program in different ways.
enum class Dimension : std::uint8_t {
  None,
  Length,
  Place,  ///< a coordinate: the format's zeros hold for it as well
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
  bool has_step = true;  ///< something states it
};

constexpr Rule described_rule(FileFormat format, Quantity quantity) {
  const bool is_1000 = format == FileFormat::F1000;
  const bool is_5000 = format == FileFormat::F5000;
  switch (quantity) {
    case Quantity::Coordinate:
      return {.n_decimals = described_decimals(format),
              .has_point = !is_1000,
              .has_sign = true,
              .dimension = Dimension::Place};
    case Quantity::ArcParameter:
      return {.n_decimals = described_decimals(format),
              .has_point = !is_1000,
              .has_sign = !is_1000,
              .dimension = Dimension::Length};
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

constexpr std::size_t kQuantities = static_cast<std::size_t>(Quantity::ToolZOffset) + 1;

/// By file format and quantity: every number of a program asks.
constexpr auto kRules = [] {
  std::array<std::array<Rule, kQuantities>, 3> rules;
  for (const FileFormat format : {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000}) {
    for (std::size_t i = 0; i < kQuantities; ++i) {
      rules[static_cast<std::size_t>(format)][i] = described_rule(format, static_cast<Quantity>(i));
    }
  }
  return rules;
}();

const Rule& rule_of(FileFormat format, Quantity quantity) {
  return kRules[static_cast<std::size_t>(format)][static_cast<std::size_t>(quantity)];
}

bool is_in_inch_per_min(const ProgramFormat& format) {
  return format.unit == LengthUnit::Inch && format.inch_rates == RateUnit::InchesPerMinute;
}

/// The same in the format of a program; its value is in that one's unit.
Rule rule_of(const ProgramFormat& format, Quantity quantity) {
  Rule rule = rule_of(format.file, quantity);
  switch (rule.dimension) {
    case Dimension::Length:
    case Dimension::Place:
      rule.has_step =
          format.has_described_step() || rule.n_decimals == described_decimals(format.file);
      rule.n_decimals += format.decimal_digits() - described_decimals(format.file);
      break;
    case Dimension::Rate:
      rule.has_step = !is_in_inch_per_min(format);
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
  if (dimension != Dimension::Rate) return inch_mm;
  return is_in_inch_per_min(format) ? inch_mm / 1000 : 1;
}

/// Whether something states what the digits of a number other than zero count.
NumberProblem open_part(const ProgramFormat& format,
                        const Rule& rule,
                        bool has_point,
                        std::size_t n_digits) {
  if (rule.dimension == Dimension::Rate && format.unit == LengthUnit::Inch && !format.inch_rates) {
    return NumberProblem::RateOpen;
  }
  if (has_point) return NumberProblem::None;
  if (!rule.has_step) return NumberProblem::StepOpen;
  // With all its digits a number is the same from the left and from the right.
  const bool leaves_zeros = static_cast<int>(n_digits) != format.integer_digits() + rule.n_decimals;
  const bool is_open =
      rule.dimension == Dimension::Length && leaves_zeros && format.zeros == Zeros::LeadingKept;
  return is_open ? NumberProblem::ZerosOpen : NumberProblem::None;
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

bool ProgramFormat::has_described_step() const {
  return unit == LengthUnit::Millimeter && decimal_digits() == described_decimals(file);
}

bool ProgramFormat::is_described() const {
  return has_described_step() && zeros == Zeros::TrailingKept;
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
  const bool is_described = format.is_described();
  const Rule& described = rule_of(format.file, quantity);
  const Rule rule = is_described ? described : rule_of(format, quantity);
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
  if (digits != 0 && !is_described) {
    const NumberProblem open = open_part(format, rule, has_point, n_digits);
    if (open != NumberProblem::None) return {.problem = open};
  }
  double factor = has_point ? rule.per_unit : rule.per_step;
  int exponent = has_point ? static_cast<int>(n_decimals) : rule.n_decimals;
  if (!is_described && !has_point && rule.dimension == Dimension::Place &&
      format.zeros == Zeros::LeadingKept) {
    const int n_most = format.integer_digits() + format.decimal_digits();
    if (static_cast<int>(n_digits) > n_most) return {.problem = NumberProblem::TooManyDigits};
    exponent = static_cast<int>(n_digits) - format.integer_digits();
    if (exponent < 0) {
      factor = kSiebMeyerPowers.at(static_cast<std::size_t>(-exponent));
      exponent = 0;
    }
  }
  const double divisor = kSiebMeyerPowers.at(static_cast<std::size_t>(exponent));
  const double unit = is_described ? 1 : unit_of(format, rule.dimension);
  const double value = static_cast<double>(is_negative ? -digits : digits) * factor / divisor;
  return {.value = unit * value, .step = unit * (factor / divisor)};
}

std::string expectation(NumberProblem problem, const ProgramFormat& format, Quantity quantity) {
  const Rule rule = rule_of(format, quantity);
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
    case NumberProblem::StepOpen:
      return (rule.has_point ? "a decimal point" : "format 5000 and a decimal point") +
             std::string(": nothing states its step without one");
    case NumberProblem::ZerosOpen:
      return fmt::format("{}all {} digits: zeros may be left off coordinates alone",
                         rule.has_point ? "a decimal point, or " : "",
                         format.integer_digits() + rule.n_decimals);
    case NumberProblem::RateOpen:
      return "rates = \"inch/min\" or \"m/min\" in [program] of machine.toml: the manual has their "
             "unit in millimetres alone";
    case NumberProblem::None:
      break;
  }
  return "";
}

}  // namespace panelcal::sieb_meyer
