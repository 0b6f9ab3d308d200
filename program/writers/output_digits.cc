// SPDX-License-Identifier: Apache-2.0
#include "program/writers/output_digits.h"

#include <cmath>

namespace panelcal {
namespace {

constexpr int kMostDigits = 6;

/// Finest digits that are written: a nanometre, and a quarter of one.
constexpr int kFinestMetric = 6;
constexpr int kFinestInch = 8;

/// In     asks_finer: than 0.01 mm
OutputDigits usual_digits(Dialect written, const ProgramInfo& source, bool asks_finer) {
  OutputDigits digits;
  if (written == Dialect::SiebMeyer) {
    digits.n_whole = kMostDigits;
    return digits;
  }
  digits.unit = source.format.unit;
  if (digits.unit == LengthUnit::Inch) {
    digits.n_whole = 2;
    digits.n_decimals = 4;
    return digits;
  }
  const bool is_coarse = source.format.decimal_digits == 2 && source.format.integer_digits <= 4;
  if (is_coarse && source.declares_digits && !source.has_decimal_coordinates && !asks_finer) {
    digits.n_whole = source.format.integer_digits;
    digits.n_decimals = 2;
  }
  return digits;
}

}  // namespace

Length OutputDigits::step() const {
  return (unit == LengthUnit::Inch ? inch(1) : mm(1)) * std::pow(10.0, -n_decimals);
}

Length OutputDigits::rounding() const {
  return step() / std::sqrt(12.0);
}

std::string OutputDigits::form() const {
  return std::string(static_cast<std::size_t>(n_whole), '0') + '.' +
         std::string(static_cast<std::size_t>(n_decimals), '0');
}

OutputDigits output_digits(Dialect written,
                           const ProgramInfo& source,
                           std::optional<Length> resolution) {
  OutputDigits digits = usual_digits(written, source, resolution && *resolution < mm(0.01));
  const int finest = digits.unit == LengthUnit::Inch ? kFinestInch : kFinestMetric;
  // A step of 0.001 mm is one of 1 um, whatever their last bits say.
  constexpr double kSame = 1 + 1e-9;
  while (resolution && digits.n_decimals < finest && digits.step() > *resolution * kSame) {
    ++digits.n_decimals;
    digits.n_whole = kMostDigits;
    digits.n_digits = digits.n_whole + digits.n_decimals;
  }
  return digits;
}

}  // namespace panelcal
