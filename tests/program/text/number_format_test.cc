// SPDX-License-Identifier: Apache-2.0
#include "program/text/number_format.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace panelcal {
namespace {

const NumberFormat kInchLeading = {};
const NumberFormat kInchTrailing = {.zeros = Zeros::TrailingKept};
const NumberFormat kMetric33 = {
    .unit = LengthUnit::Millimeter, .integer_digits = 3, .decimal_digits = 3};
const NumberFormat kMetric42 = {
    .unit = LengthUnit::Millimeter, .integer_digits = 4, .decimal_digits = 2};
const NumberFormat kMetric32 = {
    .unit = LengthUnit::Millimeter, .integer_digits = 3, .decimal_digits = 2};

double read_inch(std::string_view text, const NumberFormat& format) {
  const ParsedLength parsed = parse_length(text, format);
  EXPECT_EQ(parsed.fault, NumberFault::None) << text;
  return parsed.value.in_inch();
}

double read_mm(std::string_view text, const NumberFormat& format) {
  const ParsedLength parsed = parse_length(text, format);
  EXPECT_EQ(parsed.fault, NumberFault::None) << text;
  return parsed.value.in_mm();
}

TEST(NumberFormat, ManualLeadingAndTrailingZeros) {
  EXPECT_DOUBLE_EQ(read_inch("0075", kInchLeading), 0.75);
  EXPECT_DOUBLE_EQ(read_inch("007500", kInchLeading), 0.75);
  EXPECT_DOUBLE_EQ(read_inch("014", kInchLeading), 1.4);
  EXPECT_DOUBLE_EQ(read_inch("014000", kInchLeading), 1.4);
  EXPECT_DOUBLE_EQ(read_inch("7500", kInchTrailing), 0.75);
  EXPECT_DOUBLE_EQ(read_inch("75", kInchTrailing), 0.0075);
}

TEST(NumberFormat, ManualDecimalPlaces) {
  for (const NumberFormat& format : {kInchLeading, kInchTrailing}) {
    EXPECT_DOUBLE_EQ(read_inch(".075", format), 0.075);
    EXPECT_DOUBLE_EQ(read_inch("00.075", format), 0.075);
    EXPECT_DOUBLE_EQ(read_inch("1.45", format), 1.45);
    EXPECT_DOUBLE_EQ(read_inch("0001.45", format), 1.45);
  }
  EXPECT_DOUBLE_EQ(read_inch("00093", kInchLeading), 0.093);
  // The manual says 93 micron for 00093 in 000.00; by its own rule it is 000.93 mm.
  EXPECT_DOUBLE_EQ(read_mm("00093", kMetric32), 0.93);
}

TEST(NumberFormat, ManualMetricResolutions) {
  EXPECT_DOUBLE_EQ(read_mm("123456", kMetric33), 123.456);
  EXPECT_DOUBLE_EQ(read_mm("123456", kMetric42), 1234.56);
  EXPECT_DOUBLE_EQ(read_mm("12345", kMetric32), 123.45);
}

TEST(NumberFormat, NoDigitsAreZero) {
  EXPECT_EQ(read_inch("", kInchLeading), 0);
  EXPECT_EQ(read_inch("", kInchTrailing), 0);
}

TEST(NumberFormat, SignsCountForTheWholeNumber) {
  EXPECT_DOUBLE_EQ(read_inch("-0087", kInchLeading), -0.87);
  EXPECT_DOUBLE_EQ(read_inch("+0087", kInchLeading), 0.87);
  EXPECT_DOUBLE_EQ(read_inch("-.5", kInchLeading), -0.5);
  EXPECT_DOUBLE_EQ(read_mm("-1", {.unit = LengthUnit::Millimeter, .zeros = Zeros::TrailingKept}),
                   -0.0001);
}

TEST(NumberFormat, FewerDigitsThanTheIntegerPartAreTens) {
  EXPECT_DOUBLE_EQ(read_inch("1", kInchLeading), 10);
  EXPECT_DOUBLE_EQ(read_mm("1", kMetric33), 100);
}

TEST(NumberFormat, RefusesMoreDigitsThanTheFormatHas) {
  EXPECT_EQ(parse_length("0075000", kInchLeading).fault, NumberFault::TooManyDigits);
  EXPECT_EQ(parse_length("1234567", kInchTrailing).fault, NumberFault::TooManyDigits);
  EXPECT_EQ(parse_length("123456", kMetric32).fault, NumberFault::TooManyDigits);
  EXPECT_EQ(parse_length("1.1234567", kInchLeading).fault, NumberFault::None);
  EXPECT_EQ(parse_length("1.123456789012345", kInchLeading).fault, NumberFault::TooManyDigits);
}

/// Where the digits are stated, zeros on the left change nothing; where they are taken for granted,
/// they say that the file was written in others.
TEST(NumberFormat, StatedDigitsAllowMoreZerosOnTheLeft) {
  NumberFormat stated = {.unit = LengthUnit::Millimeter,
                         .zeros = Zeros::TrailingKept,
                         .states_digits = true,
                         .integer_digits = 3,
                         .decimal_digits = 3};
  EXPECT_DOUBLE_EQ(read_mm("00012500", stated), 12.5);
  EXPECT_DOUBLE_EQ(read_mm("-000999999", stated), -999.999);
  EXPECT_EQ(parse_length("01000000", stated).fault, NumberFault::TooManyDigits);
  stated.zeros = Zeros::LeadingKept;
  EXPECT_EQ(parse_length("00012500", stated).fault, NumberFault::TooManyDigits);
  EXPECT_EQ(parse_length("00007500", kInchTrailing).fault, NumberFault::TooManyDigits);
  EXPECT_EQ(parse_length("00000000", kInchTrailing).fault, NumberFault::TooManyDigits);
}

TEST(NumberFormat, DigitsBeyondTheFormatAreThoseOfANumberWithoutAPoint) {
  EXPECT_FALSE(has_extra_digits("123456", kInchTrailing));
  EXPECT_FALSE(has_extra_digits("-123456", kInchTrailing));
  EXPECT_TRUE(has_extra_digits("+0123456", kInchTrailing));
  EXPECT_FALSE(has_extra_digits("0123.456", kInchTrailing));
}

TEST(NumberFormat, RefusesWhatIsNoNumber) {
  for (const char* text : {"-", "+", ".", "-.", "1.2.3", "--1", "1-", "1e3", "0x1", " 1", "1 "}) {
    EXPECT_EQ(parse_length(text, kInchLeading).fault, NumberFault::Malformed) << text;
  }
}

TEST(NumberFormat, SummaryNamesUnitDigitsAndZeros) {
  EXPECT_EQ(kInchLeading.summary(), "inch 2.4, leading zeros kept");
  EXPECT_EQ(kInchLeading.header_word(), "INCH,LZ,00.0000");
  const NumberFormat trailing = {.unit = LengthUnit::Millimeter,
                                 .zeros = Zeros::TrailingKept,
                                 .integer_digits = 3,
                                 .decimal_digits = 3};
  EXPECT_EQ(trailing.summary(), "metric 3.3, trailing zeros kept");
  EXPECT_EQ(trailing.header_word(), "METRIC,TZ,000.000");
}

TEST(ParseCount, ReadsDigitsOnly) {
  EXPECT_EQ(parse_count("0"), 0);
  EXPECT_EQ(parse_count("007"), 7);
  EXPECT_EQ(parse_count("999999999"), 999'999'999);
  for (const char* text : {"", "-1", "+1", "1.", "1 ", "1000000000", "a"}) {
    EXPECT_EQ(parse_count(text), std::nullopt) << text;
  }
}

/// Writes steps of 1e-4 the way a format wants it.
std::string digits_of(int steps, int n_digits) {
  std::string text = std::to_string(std::abs(steps));
  text.insert(0, static_cast<std::size_t>(n_digits) - text.size(), '0');
  return (steps < 0 ? "-" : "") + text;
}

RC_GTEST_PROP(NumberFormat, SpellingsOfOneNumberReadTheSame, ()) {
  const int steps = *rc::gen::inRange(-999'999, 1'000'000);
  const std::string all = digits_of(steps, 6);
  std::string leading = all;
  while (leading.size() > 3 && leading.back() == '0') leading.pop_back();
  const std::string trailing = std::to_string(steps);
  const std::string point =
      std::to_string(steps / 10000) == "0" && steps < 0
          ? "-0" + digits_of(-steps % 10000, 4).insert(0, ".")
          : std::to_string(steps / 10000) + "." + digits_of(std::abs(steps) % 10000, 4);
  const Length value = parse_length(all, kInchLeading).value;
  RC_ASSERT(std::abs(value.in_inch() - steps * 1e-4) < 1e-12);
  RC_ASSERT(parse_length(leading, kInchLeading).value == value);
  RC_ASSERT(parse_length(all, kInchTrailing).value == value);
  RC_ASSERT(parse_length(trailing, kInchTrailing).value == value);
  RC_ASSERT(parse_length(point, kInchLeading).value == value);
}

}  // namespace
}  // namespace panelcal
