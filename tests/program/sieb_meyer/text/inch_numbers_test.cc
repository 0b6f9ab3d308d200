// SPDX-License-Identifier: Apache-2.0
// Numbers of programs in inch, and of other digits and zeros: what the manual leaves to FP, as
// docs/conventions.md decides it.
#include <array>
#include <string_view>

#include "program/sieb_meyer/text/numbers.h"
#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr double kInch_mm = 25.4;
constexpr double kInchPerMin_m = kInch_mm / 1000;

ProgramFormat in_inch(FileFormat file = FileFormat::F5000) {
  ProgramFormat format(file);
  format.unit = LengthUnit::Inch;
  return format;
}

ProgramFormat with_digits(ProgramFormat format, int integer_digits, int decimal_digits) {
  format.digits = {integer_digits, decimal_digits};
  return format;
}

ProgramFormat with_leading_zeros(ProgramFormat format) {
  format.zeros = Zeros::LeadingKept;
  return format;
}

double value_of(std::string_view text, const ProgramFormat& format, Quantity quantity) {
  const ParsedNumber number = parse_number(text, format, quantity);
  EXPECT_EQ(number.problem, NumberProblem::None) << text;
  return number.value;
}

/// Value of 1 without a point, in inch.
void expect_step(Quantity quantity, const ProgramFormat& format, double step_inch) {
  EXPECT_DOUBLE_EQ(value_of("1", format, quantity), step_inch * kInch_mm);
  EXPECT_DOUBLE_EQ(parse_number("1", format, quantity).step, step_inch * kInch_mm);
}

constexpr std::array kPlaces = {Quantity::Coordinate, Quantity::ArcParameter};
constexpr std::array kLengths = {Quantity::Coordinate,
                                 Quantity::ArcParameter,
                                 Quantity::Plane,
                                 Quantity::PeckLength,
                                 Quantity::ToolDiameter,
                                 Quantity::ToolZOffset};
constexpr std::array kNoLengths = {Quantity::Percent,
                                   Quantity::PerMille,
                                   Quantity::Milliseconds,
                                   Quantity::ToolSpeed,
                                   Quantity::ToolLife,
                                   Quantity::ToolDwell};

// --- with a point --------------------------------------------------------------------------------

TEST(InchNumber, EveryLengthIsInInchWithAPoint) {
  for (const Quantity quantity : kLengths) {
    EXPECT_DOUBLE_EQ(value_of("1.5", in_inch(), quantity), 1.5 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of(".0315", in_inch(), quantity), .0315 * kInch_mm);
    EXPECT_EQ(value_of("", in_inch(), quantity), 0);
  }
  EXPECT_DOUBLE_EQ(value_of("-.4", in_inch(), Quantity::Plane), -.4 * kInch_mm);
  EXPECT_DOUBLE_EQ(parse_number("1.5", in_inch(), Quantity::Coordinate).step, .1 * kInch_mm);
}

TEST(InchNumber, ARateIsInInchPerMinuteWithAPoint) {
  EXPECT_DOUBLE_EQ(value_of("47.", in_inch(), Quantity::RoutFeed), 47 * kInchPerMin_m);
  EXPECT_DOUBLE_EQ(value_of("47.2", in_inch(), Quantity::ToolFeed), 47.2 * kInchPerMin_m);
}

TEST(InchNumber, WhatIsNoLengthIsTheSame) {
  for (const FileFormat file : {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000}) {
    for (const Quantity quantity : kNoLengths) {
      const ProgramFormat format = with_digits(with_leading_zeros(in_inch(file)), 2, 4);
      EXPECT_EQ(value_of("30", format, quantity), value_of("30", file, quantity));
    }
  }
  EXPECT_EQ(value_of(".3", in_inch(), Quantity::ToolDwell), 300);
}

// --- without a point -----------------------------------------------------------------------------

/// "minimum = 0.001 mm, minimum = 0.0001 inch" (M58): a tenth of the number in millimetres.
TEST(InchNumber, AStepIsATenthOfTheNumberInMillimetres) {
  expect_step(Quantity::Coordinate, in_inch(), 0.0001);
  expect_step(Quantity::ArcParameter, in_inch(), 0.0001);
  expect_step(Quantity::Plane, in_inch(), 0.0001);
  expect_step(Quantity::PeckLength, in_inch(), 0.0001);
  expect_step(Quantity::ToolDiameter, in_inch(), 0.001);
  expect_step(Quantity::ToolZOffset, in_inch(), 0.0001);
  expect_step(Quantity::Coordinate, in_inch(FileFormat::F3000), 0.0001);
  expect_step(Quantity::Plane, in_inch(FileFormat::F3000), 0.001);
  expect_step(Quantity::ToolDiameter, in_inch(FileFormat::F3000), 0.001);
  // 0.001 m/min are 1 mm/min, 0.1 m/min are 100 mm/min.
  EXPECT_DOUBLE_EQ(value_of("1", in_inch(), Quantity::RoutFeed), 0.1 * kInchPerMin_m);
  EXPECT_DOUBLE_EQ(value_of("1", in_inch(), Quantity::ToolFeed), 10 * kInchPerMin_m);
  EXPECT_DOUBLE_EQ(value_of("5", in_inch(FileFormat::F3000), Quantity::RoutFeed),
                   50 * kInchPerMin_m);
  EXPECT_DOUBLE_EQ(value_of("5", in_inch(FileFormat::F1000), Quantity::ToolFeed),
                   50 * kInchPerMin_m);
}

/// Steps of other quantities stay the same multiple of the coordinates' as in the manual's tables.
TEST(InchNumber, StatedDigitsAreThoseOfCoordinates) {
  const ProgramFormat coarse = with_digits(in_inch(), 2, 3);
  expect_step(Quantity::Coordinate, coarse, 0.001);
  expect_step(Quantity::ArcParameter, coarse, 0.001);
  expect_step(Quantity::Plane, coarse, 0.001);
  expect_step(Quantity::ToolDiameter, coarse, 0.01);
  const ProgramFormat of_1000 = with_digits(in_inch(FileFormat::F1000), 2, 3);
  expect_step(Quantity::Coordinate, of_1000, 0.001);
  expect_step(Quantity::ToolDiameter, of_1000, 0.001);
  const ProgramFormat of_3000 = with_digits(in_inch(FileFormat::F3000), 3, 1);
  expect_step(Quantity::Coordinate, of_3000, 0.1);
  expect_step(Quantity::Plane, of_3000, 1);
  // Rates have no digits of their own.
  EXPECT_DOUBLE_EQ(value_of("1", coarse, Quantity::RoutFeed), 0.1 * kInchPerMin_m);

  const ProgramFormat fine = with_digits(FileFormat::F5000, 3, 4);
  EXPECT_DOUBLE_EQ(value_of("12345", fine, Quantity::Coordinate), 1.2345);
  EXPECT_DOUBLE_EQ(value_of("80", fine, Quantity::ToolDiameter), 0.08);
  EXPECT_DOUBLE_EQ(value_of("5", fine, Quantity::RoutFeed), 0.005);
}

TEST(InchNumber, CountsFromTheRightHoweverManyDigitsItHas) {
  const ProgramFormat format = with_digits(in_inch(), 2, 4);
  EXPECT_DOUBLE_EQ(value_of("1234567", format, Quantity::Coordinate), 123.4567 * kInch_mm);
}

/// "leading or trailing zeros" is a part of "interpretation of coordinates" (A.1).
TEST(LeadingZeros, HoldForPlacesAlone) {
  const ProgramFormat format = with_leading_zeros(in_inch());
  for (const Quantity quantity : kPlaces) {
    EXPECT_DOUBLE_EQ(value_of("0075", format, quantity), 0.75 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of("014", format, quantity), 1.4 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of("1", format, quantity), 10 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of("-012345", format, quantity), -1.2345 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of("1.5", format, quantity), 1.5 * kInch_mm);
    EXPECT_EQ(value_of("", format, quantity), 0);
  }
  expect_step(Quantity::Plane, format, 0.0001);
  expect_step(Quantity::PeckLength, format, 0.0001);
  expect_step(Quantity::ToolDiameter, format, 0.001);
  EXPECT_DOUBLE_EQ(value_of("015", with_leading_zeros(FileFormat::F5000), Quantity::Coordinate),
                   15);
}

TEST(LeadingZeros, RefuseMoreDigitsThanTheFormatHas) {
  const ProgramFormat format = with_leading_zeros(in_inch());
  EXPECT_EQ(parse_number("0123456", format, Quantity::Coordinate).problem,
            NumberProblem::TooManyDigits);
  EXPECT_EQ(parse_number("1.23456", format, Quantity::Coordinate).problem, NumberProblem::None);
  EXPECT_EQ(parse_number("0123456", format, Quantity::Plane).problem, NumberProblem::None);
  EXPECT_EQ(expectation(NumberProblem::TooManyDigits, format), "at most 6 digits");
}

// --- notation stays that of the file format ------------------------------------------------------

TEST(InchNumber, HasPointsAndSignsWhereItsFileFormatHas) {
  EXPECT_EQ(parse_number("1.", in_inch(FileFormat::F1000), Quantity::Coordinate).problem,
            NumberProblem::PointForbidden);
  EXPECT_EQ(parse_number("1.", in_inch(FileFormat::F3000), Quantity::RoutFeed).problem,
            NumberProblem::PointForbidden);
  EXPECT_EQ(parse_number("-1", in_inch(FileFormat::F1000), Quantity::ArcParameter).problem,
            NumberProblem::SignForbidden);
  EXPECT_EQ(expectation(NumberProblem::PointForbidden, in_inch(FileFormat::F1000)),
            "no decimal point here in format 1000");
}

TEST(ProgramFormat, SaysHowNumbersAreRead) {
  EXPECT_EQ(summary(in_inch()), "format 5000 in inch, 0.0001 inch without a decimal point");
  EXPECT_EQ(summary(with_digits(in_inch(FileFormat::F1000), 2, 3)),
            "format 1000 in inch, 0.001 inch, no decimal points");
  EXPECT_EQ(summary(with_leading_zeros(in_inch())),
            "format 5000 in inch, 2.4 digits from the left without a decimal point");
  EXPECT_EQ(summary(with_digits(FileFormat::F3000, 3, 4)),
            "format 3000, 0.0001 mm without a decimal point");
}

TEST(ProgramFormat, KnowsItsStep) {
  EXPECT_DOUBLE_EQ(in_inch().step_mm(), 0.00254);
  EXPECT_DOUBLE_EQ(with_digits(FileFormat::F1000, 3, 4).step_mm(), 0.0001);
  EXPECT_FALSE(in_inch().is_described());
  EXPECT_FALSE(with_leading_zeros(FileFormat::F5000).is_described());
  EXPECT_FALSE(with_digits(FileFormat::F1000, 3, 3).is_described());
  EXPECT_TRUE(with_digits(FileFormat::F1000, 3, 2).is_described());
}

}  // namespace
}  // namespace panelcal::sieb_meyer
