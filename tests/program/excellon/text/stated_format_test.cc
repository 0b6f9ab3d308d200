// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/stated_format.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/walk/options.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using Source = StatedFormat::Source;
using Digits = std::optional<std::pair<int, int>>;

PartialFormat parts(std::optional<LengthUnit> unit,
                    std::optional<Zeros> zeros,
                    Digits digits = {},
                    std::string from = "") {
  return {unit, zeros, digits, std::move(from)};
}

TEST(StatedFormat, IsTheManualsWhereNothingStatesIt) {
  const StatedFormat stated;
  EXPECT_EQ(stated.format().summary(), "inch 2.4, leading zeros kept");
  EXPECT_FALSE(stated.knows_unit() || stated.knows_zeros() || stated.knows_digits());
  EXPECT_EQ(stated.evidence(), "");
}

TEST(StatedFormat, TakesEachPartFromTheFirstSourceThatStatesIt) {
  ReadOptions reading{.forced_format = parts({}, Zeros::TrailingKept, {}, "--format tz")};
  reading.format_beside.format = parts({}, {}, std::pair(3, 5), "nc_param.txt");
  reading.last_format = parts(LengthUnit::Inch, Zeros::LeadingKept, std::pair(2, 3), "[program]");
  StatedFormat stated(reading);
  EXPECT_EQ(stated.format().summary(), "inch 3.5, trailing zeros kept");
  EXPECT_EQ(stated.evidence(), "--format tz; nc_param.txt; [program]");
  EXPECT_TRUE(stated.states_zeros());
  EXPECT_FALSE(stated.states_unit() || stated.states_digits());
  stated.add(Source::Word, parts(LengthUnit::Millimeter, Zeros::LeadingKept, {}, "line 2"));
  EXPECT_EQ(stated.format().summary(), "metric 3.5, trailing zeros kept");
  EXPECT_EQ(stated.evidence(), "--format tz; line 2; nc_param.txt");
  EXPECT_TRUE(stated.states_unit());
  EXPECT_EQ(stated.source_of_digits(), Source::Beside);
}

TEST(StatedFormat, DigitsCountForTheirUnitOnly) {
  StatedFormat stated;
  stated.add(Source::Comment, parts({}, {}, std::pair(4, 4)));
  stated.add(Source::Word, parts(LengthUnit::Inch, {}, std::pair(2, 3)));
  EXPECT_EQ(stated.format().summary(), "inch 2.3, leading zeros kept");
  stated.add(Source::Word, parts(LengthUnit::Millimeter, {}));
  EXPECT_EQ(stated.format().summary(), "metric 4.4, leading zeros kept");
  // A comment of another unit neither counts nor takes anything from those that do.
  stated.add(Source::Comment, parts(LengthUnit::Inch, Zeros::TrailingKept, std::pair(2, 5)));
  EXPECT_EQ(stated.format().summary(), "metric 4.4, leading zeros kept");
  stated.add(Source::Word, parts(LengthUnit::Inch, {}));
  EXPECT_EQ(stated.format().summary(), "inch 2.3, trailing zeros kept");
}

TEST(StatedFormat, DigitsOfTheLastSettingWithoutAUnitAreMetric) {
  const ReadOptions reading{.last_format = parts({}, {}, std::pair(4, 2))};
  StatedFormat stated(reading);
  EXPECT_EQ(stated.format().summary(), "inch 2.4, leading zeros kept");
  stated.add(Source::Word, parts(LengthUnit::Millimeter, {}));
  EXPECT_EQ(stated.format().summary(), "metric 4.2, leading zeros kept");
}

TEST(StatedFormat, ZerosOfAFileBesideItAreThoseOfItsUnit) {
  ReadOptions reading;
  reading.format_beside.format = parts(LengthUnit::Inch, Zeros::TrailingKept);
  StatedFormat stated(reading);
  stated.add(Source::Word, parts(LengthUnit::Millimeter, {}));
  EXPECT_FALSE(stated.knows_zeros());
  stated.add(Source::Word, parts(LengthUnit::Inch, {}));
  EXPECT_EQ(stated.format().zeros, Zeros::TrailingKept);
}

/// The operator's unit stays, and with it the digits that the program has stated for it.
TEST(StatedFormat, StatementsThatTheOperatorOverrulesChangeNothing) {
  StatedFormat stated(ReadOptions{.forced_format = parts(LengthUnit::Millimeter, {})});
  stated.add(Source::Word, parts(LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(4, 2)));
  EXPECT_EQ(stated.format().summary(), "metric 4.2, trailing zeros kept");
  stated.add(Source::Word, parts(LengthUnit::Inch, {}, std::pair(2, 3)));
  stated.add(Source::Comment, parts(LengthUnit::Inch, Zeros::LeadingKept, std::pair(2, 5)));
  EXPECT_EQ(stated.format().summary(), "metric 4.2, trailing zeros kept");
  const PartialFormat zeros =
      stated.obeyed(Source::Word, parts(LengthUnit::Inch, Zeros::LeadingKept, std::pair(2, 3)));
  EXPECT_EQ(zeros.zeros, Zeros::LeadingKept);
  EXPECT_FALSE(zeros.unit || zeros.digits);
}

TEST(StatedFormat, NamesEachStatementThatDecidesAPart) {
  StatedFormat stated;
  stated.add(Source::Comment, parts({}, {}, std::pair(4, 4), "line 1"));
  stated.add(Source::Comment, parts(LengthUnit::Millimeter, {}, {}, "line 2"));
  EXPECT_EQ(stated.evidence(), "line 1; line 2");
  stated.add(Source::Word, parts(LengthUnit::Millimeter, {}, std::pair(4, 2), "line 3"));
  stated.add(Source::Word, parts(LengthUnit::Millimeter, Zeros::TrailingKept, {}, "line 4"));
  EXPECT_EQ(stated.evidence(), "line 3; line 4");
}

TEST(StatedFormat, LeavesTheLastSettingOutBehindAFileThatCannotBeRead) {
  ReadOptions reading{.last_format = parts(LengthUnit::Inch, Zeros::LeadingKept)};
  reading.format_beside.fault = Diagnostic{Code::FileUnreadable, {"nc_param.txt", 0, 0}, "", ""};
  EXPECT_FALSE(StatedFormat(reading).knows_unit());
}

TEST(StatedFormat, DigitsThatOnlyTheNumbersShowAllowNoFurtherZeros) {
  StatedFormat stated;
  stated.add(Source::Numbers, parts(LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(4, 2)));
  EXPECT_EQ(stated.format().summary(), "metric 4.2, trailing zeros kept");
  EXPECT_FALSE(stated.format().states_digits);
  stated.add(Source::Setting, parts({}, {}, std::pair(4, 2)));
  EXPECT_TRUE(stated.format().states_digits);
}

TEST(StatedFormat, WarnsOfWhatTheOperatorContradicts) {
  const StatedFormat stated(ReadOptions{
      .forced_format = parts(LengthUnit::Inch, {}, std::pair(2, 4), "--format inch,2.4")});
  const auto warnings = [&](const PartialFormat& statement) {
    DiagnosticLog log;
    check_obeyed(stated, statement, "METRIC", 3, 1, Reporter("p.exc", log));
    return test::briefs(log);
  };
  const std::vector<std::string> overridden{"p.exc:3:1: warning[format-overridden]"};
  EXPECT_EQ(warnings(parts(LengthUnit::Millimeter, {})), overridden);
  EXPECT_EQ(warnings(parts({}, {}, std::pair(3, 3))), overridden);
  EXPECT_TRUE(warnings(parts(LengthUnit::Inch, Zeros::TrailingKept, std::pair(2, 4))).empty());
}

}  // namespace
}  // namespace panelcal::excellon
