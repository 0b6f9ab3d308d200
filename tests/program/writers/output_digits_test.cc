// SPDX-License-Identifier: Apache-2.0
#include "program/writers/output_digits.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

ProgramInfo source(LengthUnit unit, int integers, int decimals, bool has_points = false) {
  ProgramInfo info;
  info.format = {.unit = unit, .integer_digits = integers, .decimal_digits = decimals};
  info.has_decimal_coordinates = has_points;
  return info;
}

/// "The CNC-7 uses inches in six digits and metric in five or six digits."
TEST(OutputDigits, AreThoseThatAnExcellonSourceDeclares) {
  const auto form = [](const ProgramInfo& info) {
    return output_digits(Dialect::Excellon, info).form();
  };
  EXPECT_EQ(form(source(LengthUnit::Inch, 2, 4)), "00.0000");
  EXPECT_EQ(form(source(LengthUnit::Millimeter, 3, 3)), "000.000");
  EXPECT_EQ(form(source(LengthUnit::Millimeter, 4, 2)), "0000.00");
  EXPECT_EQ(form(source(LengthUnit::Millimeter, 3, 2)), "000.00");
}

TEST(OutputDigits, AreTheUsualOnesWhereTheSourceDeclaresOthersOrHasPoints) {
  const auto form = [](const ProgramInfo& info) {
    return output_digits(Dialect::Excellon, info).form();
  };
  EXPECT_EQ(form(source(LengthUnit::Millimeter, 4, 4)), "000.000");
  EXPECT_EQ(form(source(LengthUnit::Inch, 2, 6)), "00.0000");
  EXPECT_EQ(form(source(LengthUnit::Inch, 3, 3)), "00.0000");
  EXPECT_EQ(form(source(LengthUnit::Millimeter, 4, 2, true)), "000.000");
  ProgramInfo undeclared = source(LengthUnit::Millimeter, 3, 2);
  undeclared.declares_digits = false;
  EXPECT_EQ(form(undeclared), "000.000");
}

TEST(OutputDigits, OfSiebMeyerAreMicrometres) {
  const OutputDigits digits = output_digits(Dialect::SiebMeyer, source(LengthUnit::Inch, 2, 4));
  EXPECT_EQ(digits.unit, LengthUnit::Millimeter);
  EXPECT_EQ(digits.n_decimals, 3);
  EXPECT_EQ(digits.n_digits, 6);
}

TEST(OutputDigits, AreAddedUntilTheResolutionIsReached) {
  const auto decimals = [](LengthUnit unit, Length resolution) {
    return output_digits(Dialect::Excellon, source(unit, 3, 3), resolution).n_decimals;
  };
  EXPECT_EQ(decimals(LengthUnit::Millimeter, um(10)), 3);
  EXPECT_EQ(decimals(LengthUnit::Millimeter, um(1)), 3);
  EXPECT_EQ(decimals(LengthUnit::Millimeter, um(0.1)), 4);
  EXPECT_EQ(decimals(LengthUnit::Millimeter, um(1e-9)), 6);
  EXPECT_EQ(decimals(LengthUnit::Inch, um(1)), 5);
  EXPECT_EQ(output_digits(Dialect::Excellon, source(LengthUnit::Millimeter, 4, 2), um(1)).form(),
            "000.000");
}

/// The last digit is as likely one as the other: a uniform error of one step.
TEST(OutputDigits, RoundingIsTheSigmaOfAUniformStep) {
  const ProgramInfo coarse = source(LengthUnit::Millimeter, 4, 2);
  EXPECT_NEAR(
      output_digits(Dialect::Excellon, coarse).rounding().in_um(), 10 / std::sqrt(12.0), 1e-9);
  const ProgramInfo inches = source(LengthUnit::Inch, 2, 4);
  EXPECT_NEAR(
      output_digits(Dialect::Excellon, inches).rounding().in_um(), 2.54 / std::sqrt(12.0), 1e-9);
}

}  // namespace
}  // namespace panelcal
