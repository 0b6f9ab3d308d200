// SPDX-License-Identifier: Apache-2.0
// The unit of a number without a decimal point is the one that the manual prints at its command.
#include "program/sieb_meyer/text/numbers.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::array kFormats = {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000};

constexpr std::array kQuantities = {Quantity::Coordinate,
                                    Quantity::ArcParameter,
                                    Quantity::Plane,
                                    Quantity::RoutFeed,
                                    Quantity::PeckLength,
                                    Quantity::Percent,
                                    Quantity::PerMille,
                                    Quantity::Milliseconds,
                                    Quantity::ToolDiameter,
                                    Quantity::ToolSpeed,
                                    Quantity::ToolFeed,
                                    Quantity::ToolLife,
                                    Quantity::ToolDwell,
                                    Quantity::ToolZOffset};

NumberProblem problem_of(std::string_view text,
                         FileFormat format = FileFormat::F5000,
                         Quantity quantity = Quantity::Coordinate) {
  return parse_number(text, format, quantity).problem;
}

double value_of(std::string_view text,
                FileFormat format = FileFormat::F5000,
                Quantity quantity = Quantity::Coordinate) {
  const ParsedNumber number = parse_number(text, format, quantity);
  EXPECT_EQ(number.problem, NumberProblem::None) << text;
  return number.value;
}

/// Value of 1 in the formats 1000, 3000 and 5000; absent where the format has no such number.
void expect_units(Quantity quantity, const std::array<std::optional<double>, 3>& units) {
  for (std::size_t i = 0; i < kFormats.size(); ++i) {
    if (!units.at(i)) continue;
    SCOPED_TRACE(name(kFormats.at(i)));
    EXPECT_DOUBLE_EQ(value_of("1", kFormats.at(i), quantity), *units.at(i));
    EXPECT_DOUBLE_EQ(parse_number("1", kFormats.at(i), quantity).step, *units.at(i));
  }
}

/// In which formats `text` is refused for `problem`; it is read in the others.
void expect_problem(std::string_view text,
                    Quantity quantity,
                    NumberProblem problem,
                    std::initializer_list<FileFormat> formats) {
  for (const FileFormat format : kFormats) {
    SCOPED_TRACE(std::string(text) + " in format " + std::string(name(format)));
    const bool is_refused = std::find(formats.begin(), formats.end(), format) != formats.end();
    EXPECT_EQ(problem_of(text, format, quantity), is_refused ? problem : NumberProblem::None);
  }
}

TEST(SiebMeyerFormats, HaveNames) {
  EXPECT_EQ(name(FileFormat::F1000), "1000");
  EXPECT_EQ(name(FileFormat::F3000), "3000");
  EXPECT_EQ(name(FileFormat::F5000), "5000");
  EXPECT_EQ(summary(FileFormat::F1000), "format 1000, 0.01 mm, no decimal points");
  EXPECT_EQ(summary(FileFormat::F3000), "format 3000, 0.001 mm without a decimal point");
  EXPECT_EQ(summary(FileFormat::F5000), "format 5000, 0.001 mm without a decimal point");
}

TEST(SiebMeyerFormats, HaveTheStepOfTheirCoordinates) {
  for (const FileFormat format : kFormats) {
    EXPECT_DOUBLE_EQ(ProgramFormat(format).step_mm(),
                     parse_number("7", format, Quantity::Coordinate).step);
    EXPECT_TRUE(ProgramFormat(format).is_described());
  }
}

// --- how a number is written ---------------------------------------------------------------------

TEST(SiebMeyerNumber, WithoutDigitsIsZero) {
  for (const FileFormat format : kFormats) {
    for (const Quantity quantity : kQuantities) EXPECT_EQ(value_of("", format, quantity), 0);
  }
}

TEST(SiebMeyerNumber, CountsStepsWithoutAPoint) {
  EXPECT_DOUBLE_EQ(value_of("34567"), 34.567);
  EXPECT_DOUBLE_EQ(value_of("034567"), 34.567);
  EXPECT_DOUBLE_EQ(value_of("-5"), -0.005);
  EXPECT_DOUBLE_EQ(value_of("+5"), 0.005);
  EXPECT_DOUBLE_EQ(value_of("12345", FileFormat::F1000), 123.45);
}

TEST(SiebMeyerNumber, IsInItsUnitWithAPoint) {
  EXPECT_DOUBLE_EQ(value_of("12.345"), 12.345);
  EXPECT_DOUBLE_EQ(value_of("30."), 30);
  EXPECT_DOUBLE_EQ(value_of(".45"), 0.45);
  EXPECT_DOUBLE_EQ(value_of("-1.02"), -1.02);
  EXPECT_DOUBLE_EQ(value_of("+.5"), 0.5);
  EXPECT_DOUBLE_EQ(value_of("-0"), 0);
}

TEST(SiebMeyerNumber, KnowsWhatItsLastDigitAdds) {
  EXPECT_DOUBLE_EQ(parse_number("30.", FileFormat::F5000, Quantity::Coordinate).step, 1);
  EXPECT_DOUBLE_EQ(parse_number("1.5", FileFormat::F5000, Quantity::Coordinate).step, 0.1);
  EXPECT_DOUBLE_EQ(parse_number("1.2345", FileFormat::F5000, Quantity::Coordinate).step, 0.0001);
  EXPECT_DOUBLE_EQ(parse_number("15", FileFormat::F5000, Quantity::Coordinate).step, 0.001);
}

TEST(SiebMeyerNumber, IsTheNearestDouble) {
  // Digits over a power of ten is one rounding, as the compiler's own reading is.
  EXPECT_EQ(value_of("123.456"), 123.456);
  EXPECT_EQ(value_of("0.1"), 0.1);
  EXPECT_EQ(value_of("536224"), 536.224);
  EXPECT_EQ(value_of("-223.11"), -223.11);
  EXPECT_EQ(value_of("123456789012345"), 123456789012.345);
  EXPECT_EQ(value_of(".123456789012345"), .123456789012345);
}

TEST(SiebMeyerNumber, RefusesWhatIsNoNumber) {
  for (const std::string_view text : {"-",
                                      "+",
                                      ".",
                                      "-.",
                                      "1.2.3",
                                      "1-2",
                                      "1+",
                                      "--1",
                                      "+-1",
                                      "1..",
                                      " 1",
                                      "1 ",
                                      "1,5",
                                      "1e3",
                                      "A"}) {
    EXPECT_EQ(problem_of(text), NumberProblem::Malformed) << text;
  }
  EXPECT_EQ(problem_of(std::string_view("1\0", 2)), NumberProblem::Malformed);
}

TEST(SiebMeyerNumber, HasAtMost15Digits) {
  EXPECT_EQ(problem_of("123456789012345"), NumberProblem::None);
  EXPECT_EQ(problem_of("1234567890.12345"), NumberProblem::None);
  EXPECT_EQ(problem_of("1234567890123456"), NumberProblem::TooLong);
  EXPECT_EQ(problem_of("1234567890.123456"), NumberProblem::TooLong);
  EXPECT_EQ(problem_of("0000000000000001"), NumberProblem::TooLong);
  EXPECT_EQ(problem_of(std::string(1000, '9')), NumberProblem::TooLong);
}

TEST(SiebMeyerNumber, SaysWhatWasExpected) {
  EXPECT_EQ(expectation(NumberProblem::Malformed, FileFormat::F5000),
            "a sign, digits and at most one decimal point");
  EXPECT_EQ(expectation(NumberProblem::TooLong, FileFormat::F5000), "at most 15 digits");
  EXPECT_EQ(expectation(NumberProblem::PointForbidden, FileFormat::F1000),
            "no decimal point here in format 1000");
  EXPECT_EQ(expectation(NumberProblem::SignForbidden, FileFormat::F3000),
            "a number that is not negative");
}

// --- units, in the manual's words ----------------------------------------------------------------

/// "X1 = 0.01 mm", "X1 = 0.001 mm"; "millimeter point not allowed" in format 1000.
TEST(ManualUnits, OfCoordinates) {
  expect_units(Quantity::Coordinate, {0.01, 0.001, 0.001});
  expect_problem("1.", Quantity::Coordinate, NumberProblem::PointForbidden, {FileFormat::F1000});
  expect_problem("-1", Quantity::Coordinate, NumberProblem::None, {});
}

/// "I1 = 0.01 mm", "I1 = 0.001 mm", "R1 = 0.001 mm", "D1 = 0.001 mm".
TEST(ManualUnits, OfArcParameters) {
  expect_units(Quantity::ArcParameter, {0.01, 0.001, 0.001});
  expect_problem("1.", Quantity::ArcParameter, NumberProblem::PointForbidden, {FileFormat::F1000});
  // One quadrant, which its end tells: lengths only.
  expect_problem("-1", Quantity::ArcParameter, NumberProblem::SignForbidden, {FileFormat::F1000});
}

/// "H1 = 0.01 mm" in format 3000, "H1 = 0.001 mm" in format 5000; K and Z the same.
TEST(ManualUnits, OfPlanes) {
  expect_units(Quantity::Plane, {std::nullopt, 0.01, 0.001});
  expect_problem("-1", Quantity::Plane, NumberProblem::None, {});
  EXPECT_DOUBLE_EQ(value_of("-.4", FileFormat::F5000, Quantity::Plane), -0.4);
}

/// "F1 = 0.1 m/min. No decimal point allowed!"; "F1 = 0.001 m/min. Decimal point is allowed!"
TEST(ManualUnits, OfRoutFeeds) {
  expect_units(Quantity::RoutFeed, {0.1, 0.1, 0.001});
  expect_problem("1.2",
                 Quantity::RoutFeed,
                 NumberProblem::PointForbidden,
                 {FileFormat::F1000, FileFormat::F3000});
  EXPECT_DOUBLE_EQ(value_of("15", FileFormat::F1000, Quantity::RoutFeed), 1.5);
  EXPECT_DOUBLE_EQ(value_of("1.2", FileFormat::F5000, Quantity::RoutFeed), 1.2);
}

TEST(ManualUnits, OfPeckDrilling) {
  expect_units(Quantity::PeckLength, {std::nullopt, std::nullopt, 0.001});
  expect_units(Quantity::Percent, {std::nullopt, std::nullopt, 1.0});
  expect_units(Quantity::PerMille, {std::nullopt, std::nullopt, 1.0});
  expect_units(Quantity::Milliseconds, {std::nullopt, std::nullopt, 1.0});
  EXPECT_DOUBLE_EQ(value_of("1.4", FileFormat::F5000, Quantity::PeckLength), 1.4);
}

/// Tables of A.5 to A.7: D 0.01 mm, S 1000 rpm, F and R 0.1 m/min, N 100 strokes or 1 stroke, A 1
/// ms, Z 0.001 mm.
TEST(ManualUnits, OfToolTables) {
  expect_units(Quantity::ToolDiameter, {0.01, 0.01, 0.01});
  expect_units(Quantity::ToolSpeed, {1.0, 1.0, 1.0});
  expect_units(Quantity::ToolFeed, {0.1, 0.1, 0.1});
  expect_units(Quantity::ToolLife, {100.0, 100.0, 1.0});
  expect_units(Quantity::ToolDwell, {1.0, 1.0, 1.0});
  expect_units(Quantity::ToolZOffset, {std::nullopt, std::nullopt, 0.001});
}

/// "D.8 = 0.8 mm", "F1.2 = 1.2 m/min", "R9.9 = 9.9 m/min", "A.3 = 300 ms", "Z.01 = 0.01 mm".
TEST(ManualUnits, OfToolTablesWithPoints) {
  const auto value = [](std::string_view text, Quantity quantity) {
    return value_of(text, FileFormat::F5000, quantity);
  };
  EXPECT_DOUBLE_EQ(value(".8", Quantity::ToolDiameter), 0.8);
  EXPECT_DOUBLE_EQ(value("50.", Quantity::ToolSpeed), 50);
  EXPECT_DOUBLE_EQ(value("9.9", Quantity::ToolFeed), 9.9);
  EXPECT_DOUBLE_EQ(value(".3", Quantity::ToolDwell), 300);
  EXPECT_DOUBLE_EQ(value(".01", Quantity::ToolZOffset), 0.01);
}

TEST(ManualUnits, OfToolTablesHavePointsInFormat5000Only) {
  for (const Quantity quantity :
       {Quantity::ToolDiameter, Quantity::ToolSpeed, Quantity::ToolFeed, Quantity::ToolDwell}) {
    expect_problem(
        "1.5", quantity, NumberProblem::PointForbidden, {FileFormat::F1000, FileFormat::F3000});
  }
  expect_problem("1.5",
                 Quantity::ToolLife,
                 NumberProblem::PointForbidden,
                 {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000});
}

TEST(ManualUnits, AreNegativeOnlyWhereThatMeansSomething) {
  for (const Quantity quantity : {Quantity::RoutFeed,
                                  Quantity::PeckLength,
                                  Quantity::Percent,
                                  Quantity::PerMille,
                                  Quantity::Milliseconds,
                                  Quantity::ToolDiameter,
                                  Quantity::ToolSpeed,
                                  Quantity::ToolFeed,
                                  Quantity::ToolLife,
                                  Quantity::ToolDwell}) {
    expect_problem("-1",
                   quantity,
                   NumberProblem::SignForbidden,
                   {FileFormat::F1000, FileFormat::F3000, FileFormat::F5000});
    expect_problem("+1", quantity, NumberProblem::None, {});
  }
  // A tool's offset is added to the working plane, either way.
  EXPECT_DOUBLE_EQ(value_of("-.3", FileFormat::F5000, Quantity::ToolZOffset), -0.3);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
