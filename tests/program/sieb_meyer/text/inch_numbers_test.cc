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
constexpr double kInchPerMin_m = kInch_mm / 1000;  // in m/min

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

ProgramFormat with_rates(ProgramFormat format, RateUnit unit) {
  format.inch_rates = unit;
  return format;
}

NumberProblem problem_of(std::string_view text, const ProgramFormat& format, Quantity quantity) {
  return parse_number(text, format, quantity).problem;
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

constexpr std::array kLengths = {Quantity::Coordinate,
                                 Quantity::ArcParameter,
                                 Quantity::Plane,
                                 Quantity::PeckLength,
                                 Quantity::ToolDiameter,
                                 Quantity::ToolZOffset};
constexpr std::array kRates = {Quantity::RoutFeed, Quantity::ToolFeed};
constexpr std::array kFiles = {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000};
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

TEST(InchNumber, WhatIsNoLengthIsTheSame) {
  for (const FileFormat file : kFiles) {
    for (const Quantity quantity : kNoLengths) {
      const ProgramFormat format = with_digits(with_leading_zeros(in_inch(file)), 2, 4);
      EXPECT_EQ(value_of("30", format, quantity), value_of("30", file, quantity));
    }
  }
  EXPECT_EQ(value_of(".3", in_inch(), Quantity::ToolDwell), 300);
}

// --- without a point -----------------------------------------------------------------------------

/// "minimum = 0.001 mm, minimum = 0.0001 inch" (M58), and the lengths that have the coordinates'
/// step in the tables follow it.
TEST(InchNumber, AStepIsTheOneOfCoordinates) {
  for (const Quantity quantity : {Quantity::Coordinate,
                                  Quantity::ArcParameter,
                                  Quantity::Plane,
                                  Quantity::PeckLength,
                                  Quantity::ToolZOffset}) {
    expect_step(quantity, in_inch(), 0.0001);
    expect_step(quantity, with_digits(in_inch(), 2, 3), 0.001);
  }
  expect_step(Quantity::Coordinate, in_inch(FileFormat::F3000), 0.0001);
  const ProgramFormat of_1000 = with_digits(in_inch(FileFormat::F1000), 2, 3);
  expect_step(Quantity::Coordinate, of_1000, 0.001);
  expect_step(Quantity::ToolDiameter, of_1000, 0.001);
}

/// A resolution that is stated is that of coordinates: what has another one in the tables (Z1 and
/// D1 are 0.01 mm beside X1 = 0.001 mm) may have any.
TEST(InchNumber, HasNoStepWhereTheTablesHaveAnotherThanOfCoordinates) {
  const ProgramFormat of_3000 = in_inch(FileFormat::F3000);
  for (const ProgramFormat& format : {in_inch(),
                                      with_digits(in_inch(), 2, 3),
                                      ProgramFormat(with_digits(FileFormat::F5000, 3, 4))}) {
    EXPECT_EQ(problem_of("80", format, Quantity::ToolDiameter), NumberProblem::StepOpen);
    EXPECT_EQ(problem_of(".8", format, Quantity::ToolDiameter), NumberProblem::None);
    EXPECT_EQ(problem_of("0", format, Quantity::ToolDiameter), NumberProblem::None);
    EXPECT_EQ(problem_of("", format, Quantity::ToolDiameter), NumberProblem::None);
  }
  EXPECT_EQ(problem_of("20", of_3000, Quantity::Plane), NumberProblem::StepOpen);
  EXPECT_DOUBLE_EQ(value_of(".02", of_3000, Quantity::Plane), .02 * kInch_mm);
  EXPECT_EQ(problem_of("80", of_3000, Quantity::ToolDiameter), NumberProblem::StepOpen);
  EXPECT_EQ(expectation(NumberProblem::StepOpen, in_inch(), Quantity::ToolDiameter),
            "a decimal point: nothing states its step without one");
  EXPECT_EQ(expectation(NumberProblem::StepOpen, of_3000, Quantity::ToolDiameter).substr(0, 31),
            "format 5000 and a decimal point");
  // With the tables' own digits nothing changes.
  EXPECT_DOUBLE_EQ(value_of("80", with_digits(FileFormat::F3000, 4, 3), Quantity::ToolDiameter),
                   0.8);
  EXPECT_DOUBLE_EQ(value_of("20", with_digits(FileFormat::F3000, 4, 3), Quantity::Plane), 0.2);
}

TEST(OtherDigits, AreThoseOfLengthsInMillimetresToo) {
  const ProgramFormat fine = with_digits(FileFormat::F5000, 3, 4);
  EXPECT_DOUBLE_EQ(value_of("12345", fine, Quantity::Coordinate), 1.2345);
  EXPECT_DOUBLE_EQ(value_of("12345", fine, Quantity::Plane), 1.2345);
  // Rates have no digits of their own.
  EXPECT_DOUBLE_EQ(value_of("5", fine, Quantity::RoutFeed), 0.005);
}

// --- rates ---------------------------------------------------------------------------------------

/// "F1 = 0.001 m/min", "Length-dependent values depend on the active format": nothing says whether
/// a rate is one of them.
TEST(InchRate, HasToBeStated) {
  for (const FileFormat file : kFiles) {
    for (const Quantity quantity : kRates) {
      EXPECT_EQ(problem_of("50", in_inch(file), quantity), NumberProblem::RateOpen);
      EXPECT_EQ(problem_of("0", in_inch(file), quantity), NumberProblem::None);
      EXPECT_EQ(problem_of("", in_inch(file), quantity), NumberProblem::None);
    }
  }
  EXPECT_EQ(problem_of("50.", in_inch(), Quantity::RoutFeed), NumberProblem::RateOpen);
  EXPECT_EQ(expectation(NumberProblem::RateOpen, in_inch()).substr(0, 39),
            "rates = \"inch/min\" or \"m/min\" in [progr");
}

/// In m/min the tables hold.
TEST(InchRate, IsWhatTheTablesSayInMetresPerMinute) {
  for (const FileFormat file : kFiles) {
    const ProgramFormat format = with_rates(in_inch(file), RateUnit::MetersPerMinute);
    for (const Quantity quantity : kRates) {
      EXPECT_EQ(value_of("15", format, quantity), value_of("15", file, quantity));
    }
  }
  EXPECT_EQ(value_of("1.5", with_rates(in_inch(), RateUnit::MetersPerMinute), Quantity::RoutFeed),
            1.5);
}

TEST(InchRate, HasAPointInInchPerMinute) {
  const ProgramFormat format = with_rates(in_inch(), RateUnit::InchesPerMinute);
  EXPECT_DOUBLE_EQ(value_of("47.", format, Quantity::RoutFeed), 47 * kInchPerMin_m);
  EXPECT_DOUBLE_EQ(value_of("47.2", format, Quantity::ToolFeed), 47.2 * kInchPerMin_m);
  for (const FileFormat file : kFiles) {
    const ProgramFormat other = with_rates(in_inch(file), RateUnit::InchesPerMinute);
    EXPECT_EQ(problem_of("47", other, Quantity::RoutFeed), NumberProblem::StepOpen);
    EXPECT_EQ(problem_of("47", other, Quantity::ToolFeed), NumberProblem::StepOpen);
  }
}

/// Programs in millimetres have the manual's, whatever a control in inch has.
TEST(InchRate, IsOfProgramsInInchAlone) {
  EXPECT_EQ(
      value_of("15", with_rates(FileFormat::F3000, RateUnit::InchesPerMinute), Quantity::RoutFeed),
      1.5);
}

// --- digits and zeros ----------------------------------------------------------------------------

TEST(InchNumber, CountsFromTheRightHoweverManyDigitsItHas) {
  const ProgramFormat format = with_digits(in_inch(), 2, 4);
  EXPECT_DOUBLE_EQ(value_of("1234567", format, Quantity::Coordinate), 123.4567 * kInch_mm);
}

/// "leading or trailing zeros" is a part of "interpretation of coordinates" (A.1).
TEST(LeadingZeros, HoldForCoordinates) {
  const ProgramFormat format = with_leading_zeros(in_inch());
  EXPECT_DOUBLE_EQ(value_of("0075", format, Quantity::Coordinate), 0.75 * kInch_mm);
  EXPECT_DOUBLE_EQ(value_of("014", format, Quantity::Coordinate), 1.4 * kInch_mm);
  EXPECT_DOUBLE_EQ(value_of("1", format, Quantity::Coordinate), 10 * kInch_mm);
  EXPECT_DOUBLE_EQ(value_of("-012345", format, Quantity::Coordinate), -1.2345 * kInch_mm);
  EXPECT_DOUBLE_EQ(value_of("1.5", format, Quantity::Coordinate), 1.5 * kInch_mm);
  EXPECT_EQ(value_of("", format, Quantity::Coordinate), 0);
  EXPECT_DOUBLE_EQ(value_of("015", with_leading_zeros(FileFormat::F5000), Quantity::Coordinate),
                   15);
}

/// Radii and planes are no coordinates: only where both readings are one they have a value.
TEST(LeadingZeros, ThatAreLeftOffOtherLengthsHaveNoReading) {
  const ProgramFormat format = with_leading_zeros(in_inch());
  for (const Quantity quantity :
       {Quantity::ArcParameter, Quantity::Plane, Quantity::PeckLength, Quantity::ToolZOffset}) {
    EXPECT_EQ(problem_of("0075", format, quantity), NumberProblem::ZerosOpen);
    EXPECT_EQ(problem_of("7500", format, quantity), NumberProblem::ZerosOpen);
    EXPECT_EQ(problem_of("0123456", format, quantity), NumberProblem::ZerosOpen);
    EXPECT_DOUBLE_EQ(value_of("007500", format, quantity), 0.75 * kInch_mm);
    EXPECT_DOUBLE_EQ(value_of(".75", format, quantity), 0.75 * kInch_mm);
    EXPECT_EQ(value_of("0", format, quantity), 0);
  }
  EXPECT_EQ(expectation(NumberProblem::ZerosOpen, format, Quantity::Plane),
            "a decimal point, or all 6 digits: zeros may be left off coordinates alone");
  // 0.01 mm beside 0.001 mm: one digit fewer; no point in D of format 3000.
  const ProgramFormat of_3000 = with_leading_zeros(FileFormat::F3000);
  EXPECT_DOUBLE_EQ(value_of("00080", of_3000, Quantity::ToolDiameter), 0.8);
  EXPECT_EQ(problem_of("80", of_3000, Quantity::ToolDiameter), NumberProblem::ZerosOpen);
  EXPECT_EQ(expectation(NumberProblem::ZerosOpen, of_3000, Quantity::ToolDiameter).substr(0, 12),
            "all 5 digits");
  EXPECT_EQ(value_of("30", format, Quantity::ToolLife), 30);
}

TEST(LeadingZeros, RefuseMoreDigitsThanTheFormatHas) {
  const ProgramFormat format = with_leading_zeros(in_inch());
  EXPECT_EQ(parse_number("0123456", format, Quantity::Coordinate).problem,
            NumberProblem::TooManyDigits);
  EXPECT_EQ(parse_number("1.23456", format, Quantity::Coordinate).problem, NumberProblem::None);
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
  EXPECT_TRUE(with_leading_zeros(FileFormat::F5000).has_described_step());
  EXPECT_FALSE(in_inch().has_described_step());
  EXPECT_FALSE(with_digits(FileFormat::F1000, 3, 3).is_described());
  EXPECT_TRUE(with_digits(FileFormat::F1000, 3, 2).is_described());
}

}  // namespace
}  // namespace panelcal::sieb_meyer
