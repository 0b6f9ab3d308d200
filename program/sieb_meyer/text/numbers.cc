// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/numbers.h"

#include <array>
#include <cstddef>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::array<double, 16> kSiebMeyerPowers = {
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// Notation of a quantity in a format: value = digits * per_step / divisor without a point.
struct Rule {
  double per_step = 1;
  double divisor = 1;
  bool has_point = true;
  bool has_sign = false;
  double per_unit = 1;  ///< with a point
};

Rule rule_of(FileFormat format, Quantity quantity) {
  const bool is_1000 = format == FileFormat::F1000;
  const bool is_5000 = format == FileFormat::F5000;
  switch (quantity) {
    case Quantity::Coordinate:
      return {.divisor = is_1000 ? 100.0 : 1000.0, .has_point = !is_1000, .has_sign = true};
    case Quantity::ArcParameter:
      return {.divisor = is_1000 ? 100.0 : 1000.0, .has_point = !is_1000, .has_sign = !is_1000};
    case Quantity::Plane:
      return {.divisor = is_5000 ? 1000.0 : 100.0, .has_sign = true};
    case Quantity::RoutFeed:
      return {.divisor = is_5000 ? 1000.0 : 10.0, .has_point = is_5000};
    case Quantity::PeckLength:
    case Quantity::ToolZOffset:
      return {.divisor = 1000.0, .has_sign = quantity == Quantity::ToolZOffset};
    case Quantity::ToolDiameter:
      return {.divisor = 100.0, .has_point = is_5000};
    case Quantity::ToolFeed:
      return {.divisor = 10.0, .has_point = is_5000};
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

std::string summary(FileFormat format) {
  return "format " + std::string(name(format)) +
         (format == FileFormat::F1000 ? ", 0.01 mm, no decimal points"
                                      : ", 0.001 mm without a decimal point");
}

ParsedNumber parse_number(std::string_view text, FileFormat format, Quantity quantity) {
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
  const double factor = has_point ? rule.per_unit : rule.per_step;
  const double divisor = has_point ? kSiebMeyerPowers.at(n_decimals) : rule.divisor;
  const double value = static_cast<double>(is_negative ? -digits : digits) * factor / divisor;
  return {.value = value, .step = factor / divisor};
}

std::string expectation(NumberProblem problem, FileFormat format) {
  switch (problem) {
    case NumberProblem::Malformed:
      return "a sign, digits and at most one decimal point";
    case NumberProblem::TooLong:
      return "at most 15 digits";
    case NumberProblem::PointForbidden:
      return "no decimal point here in format " + std::string(name(format));
    case NumberProblem::SignForbidden:
      return "a number that is not negative";
    case NumberProblem::None:
      break;
  }
  return "";
}

}  // namespace panelcal::sieb_meyer
