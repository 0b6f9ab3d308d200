// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/units.h"
#include "program/model/operation.h"
#include "program/text/number_format.h"

namespace panelcal {

/// The digits of the lengths in a written program: what the control can read.
struct OutputDigits {
  LengthUnit unit = LengthUnit::Millimeter;
  int n_whole = 3;     ///< at most, before the point
  int n_decimals = 3;  ///< at most, behind it
  int n_digits = 6;    ///< at most, together; leading zeros before the point do not count

  /// Of the last digit.
  Length step() const;
  /// Standard deviation of the rounding to the last digit, along each axis: step / sqrt(12).
  Length rounding() const;
  /// "000.000", "00.0000" and so on.
  std::string form() const;

  friend bool operator==(const OutputDigits&, const OutputDigits&) = default;
};

/// The digits that a program in `written` may have.
///
/// Excellon: those that the source declares, at most six (inch 00.0000, metric 000.000, 0000.00 or
/// 000.00). Where it declares others or none, or has decimal points in its coordinates, 00.0000 or
/// 000.000. SIEB & MEYER: 0.001 mm, the step of its numbers without a point, and six digits, a
/// decision.
///
/// In     resolution: asked for by the operator; digits are added behind the point until the last
///        one is as fine, up to a nanometre. Such a control reads more than six.
/// Source CNC-7 manual, Inch vs. Metric (six digits at most); SIEB & MEYER CNC 8x.00 Command Set,
///        X: X-coordinate (0.001 mm); docs/decisions/self_contained_output.md
/// See    tests/program/writers/output_digits_test.cc
OutputDigits output_digits(Dialect written,
                           const ProgramInfo& source,
                           std::optional<Length> resolution = std::nullopt);

}  // namespace panelcal
