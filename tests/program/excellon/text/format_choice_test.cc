// SPDX-License-Identifier: Apache-2.0
// A program that leaves its number format open is read in the one that its numbers can be meant in,
// or not at all.
#include "program/excellon/text/format_choice.h"

#include <string>
#include <vector>

#include "program/excellon/text/header_reader.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using testing::HasSubstr;

struct Read {
  Header header;
  std::vector<std::string> diagnostics;  ///< without their wording
  std::string text;                      ///< of the first one
};

Read read(const std::string& program, const ReadOptions& reading = {}) {
  DiagnosticLog log;
  Read out;
  out.header = read_header({"p.exc", program}, reading, log);
  out.diagnostics = test::briefs(log);
  if (!log.kept().empty()) out.text = log.kept().front().text();
  return out;
}

std::string summary(const std::string& program, const ReadOptions& reading = {}) {
  return read(program, reading).header.number_summary();
}

using Lines = std::vector<std::string>;

// --- what cannot be decided ----------------------------------------------------------------------

TEST(FormatChoice, RefusesWhatCanBeMeantInInchAndInMetric) {
  const Read out = read("T1\nX01Y02\nX03Y04\nM30\n");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:2:1: error[format-ambiguous]"});
  EXPECT_TRUE(out.header.is_refused);
  EXPECT_THAT(out.text,
              HasSubstr("inch 2.4, leading zeros kept (x 25.4 to 76.2, y 50.8 to 101.6 mm)"));
  EXPECT_THAT(out.text, HasSubstr("metric 3.3, leading zeros kept (x 10 to 30, y 20 to 40 mm)"));
}

TEST(FormatChoice, RefusesDecimalPointsWithoutAUnit) {
  EXPECT_EQ(read("T1\nX1.5Y2.0\nX3.5Y4.0\nM30\n").diagnostics,
            Lines{"p.exc:2:1: error[format-ambiguous]"});
}

TEST(FormatChoice, RefusesZerosThatTellNothing) {
  EXPECT_EQ(read("M48\nINCH\nT1C.032\n%\nT1\nX1234Y2345\nX1111Y1112\nM30\n").diagnostics,
            Lines{"p.exc:6:1: error[format-ambiguous]"});
}

TEST(FormatChoice, RefusesZerosThatContradictEachOther) {
  EXPECT_EQ(read("M48\nINCH\n%\nT1\nX0123Y0234\nX1230Y1240\nM30\n").diagnostics,
            Lines{"p.exc:5:1: error[format-ambiguous]"});
}

TEST(FormatChoice, RefusesWhatNoReadingHas) {
  const Read far =
      read("M48\nINCH\nT1C.032\n%\nT1\nX98Y99\nX96Y97\nM30\n", {.travel_mm = {{40, 40}}});
  EXPECT_EQ(far.diagnostics, Lines{"p.exc:6:1: error[format-ambiguous]"});
  EXPECT_THAT(far.text, HasSubstr("coordinates would be"));
}

TEST(FormatChoice, RefusesWithLinesThatAreNoBlocksWhichAreNamedWhereTheyStand) {
  const Read out = read("T1\nX01Y02\n#\nM30\n");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:2:1: error[format-ambiguous]"});
  EXPECT_FALSE(out.header.is_refused);  // so that the walk comes to line 3
}

TEST(FormatChoice, LooksAtNothingThatIsNotExecuted) {
  const Lines ambiguous{"p.exc:2:1: error[format-ambiguous]"};
  for (const char* end : {"\x1A", "X12345678", "?? END 1.5", "."}) {
    const std::string program = std::string("T1C.5\nX1234Y2345\nX4321Y5432\nM30\n") + end + "\n";
    EXPECT_EQ(read(program).diagnostics, ambiguous) << end;
  }
  const std::string deleted = "T1C.5\nX1234Y2345\nX4321Y5432\n/X12345678Y1\n/#\nM30\n";
  EXPECT_EQ(read(deleted, {.block_delete = true}).diagnostics, ambiguous);
}

TEST(FormatChoice, RefusesOtherLengthsWhoseZerosAreOpen) {
  const std::string head = "M48\nMETRIC\nT1C0.8\n%\nT1\nX1.0Y2.0\nX8.0Y9.0\n";
  for (const char* body : {"G93X1000Y2000\n",
                           "G00X1.0Y0\nM15\nG03X10.0Y0A10000\n",
                           "G34,1,1000\n",
                           "$uvis,searcharea,1000\n",
                           "X5.0Y5.0G84X5\n"}) {
    EXPECT_THAT(read(head + body + "M30\n").diagnostics,
                testing::ElementsAre("p.exc:6:1: error[format-ambiguous]"))
        << body;
  }
  EXPECT_THAT(read("M48\nMETRIC\nT1C0.8Z-100\n%\nT1\nX1.0Y2.0\nM30\n").diagnostics,
              testing::ElementsAre("p.exc:6:1: error[format-ambiguous]"));
  EXPECT_THAT(read("M48\nMETRIC\nCP,1,05\n%\nT1\nX1.0Y2.0\nM30\n").diagnostics,
              testing::Contains("p.exc:6:1: error[format-ambiguous]"));
}

TEST(FormatChoice, RefusesRatesWithoutAUnit) {
  EXPECT_EQ(read("T1F200\nX0Y0\nM30\n").diagnostics, Lines{"p.exc:2:1: error[format-ambiguous]"});
}

TEST(FormatChoice, StoredPatternsCountAsWell) {
  const auto patterns = [](std::string_view) { return std::vector<std::string>{"X1000Y2000\n"}; };
  DiagnosticLog log;
  const std::string program = "M48\nMETRIC\n%\nT1\nX1.0Y2.0\nM99,PAT\nX10.0Y10.0\nM30\n";
  read_header({"p.exc", program}, {}, log, patterns);
  EXPECT_EQ(test::briefs(log), Lines{"p.exc:5:1: error[format-ambiguous]"});
}

// --- what does not matter ------------------------------------------------------------------------

TEST(FormatChoice, TakesNumbersThatMeanTheSameInAllReadings) {
  EXPECT_EQ(read("M48\nMETRIC\nT1C.5\n%\nT1\nX008380Y002380\nM30\n").diagnostics, Lines{});
  EXPECT_EQ(read("M48\nINCH\nT1C.02\n%\nT1\nX1.5Y2.0\nM30\n").diagnostics, Lines{});
  EXPECT_EQ(read("T1\nX0Y0\nXY\nM30\n").diagnostics, Lines{});
}

TEST(FormatChoice, LetsTheWalkComeToNumbersThatNoFormatHas) {
  const Read out = read("M48\nMETRIC\n%\nT1\nX12345678Y1\nM30\n");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: error[format-ambiguous]"});
  EXPECT_FALSE(out.header.is_refused);
}

// --- what decides --------------------------------------------------------------------------------

TEST(FormatChoice, DrillsHaveNoDiameterOfMicrometresOrInches) {
  const Read out = read("M48\nT1C.020\n%\nT1\nX1.5Y2.0\nX3.5Y4.0\nM30\n");
  EXPECT_EQ(out.header.format.unit, LengthUnit::Inch);
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: warning[format-assumed]"});
  EXPECT_THAT(out.text, HasSubstr("a drill would have 0.02 mm"));
  EXPECT_EQ(summary("M48\nT1C.864\n%\nT1\nX1.5Y2.0\nX3.5Y4.0\nM30\n"),
            "metric 3.3, leading zeros kept");
}

TEST(FormatChoice, NumbersKeepNoZerosThatTheFormatLeavesOff) {
  EXPECT_EQ(summary("M48\nINCH\n%\nT1\nX0123Y0234\nX12345Y1245\nM30\n"),
            "inch 2.4, leading zeros kept");
  EXPECT_EQ(summary("M48\nINCH\n%\nT1\nX12300Y2300\nX1234Y1245\nM30\n"),
            "inch 2.4, trailing zeros kept");
}

TEST(FormatChoice, NumbersOfOneLengthLeaveNothingOff) {
  EXPECT_EQ(read("M48\nMETRIC\n%\nT1\nX12500Y10500\nX23000Y15000\nM30\n").diagnostics,
            Lines{"p.exc:5:1: error[format-ambiguous]"});
}

TEST(FormatChoice, OneZeroMayBeASlip) {
  EXPECT_EQ(read("M48\nINCH\n%\nT1\nX0123Y2345\nX1234Y1245\nM30\n").diagnostics,
            Lines{"p.exc:5:1: error[format-ambiguous]"});
}

TEST(FormatChoice, CoordinatesStayWithinTheTravel) {
  const std::string program = "M72\nT1\nX69724Y10689\nX43741Y11111\nM30\n";
  EXPECT_EQ(summary(program), "inch 2.4, trailing zeros kept");
  const std::string wide = "M48\nMETRIC\n%\nT1\nX0011Y0011\nX71111Y1111\nM30\n";
  EXPECT_EQ(read(wide).header.format.zeros, Zeros::LeadingKept);
  EXPECT_THAT(read(wide, {.travel_mm = {{500, 500}}}).diagnostics,
              testing::ElementsAre("p.exc:5:1: error[format-ambiguous]"));
}

TEST(FormatChoice, AxesMayBeSwapped) {
  const ReadOptions reading{.travel_mm = {{300, 700}}};
  const std::string program = "M48\nVER,2\nMETRIC\nT1C0.8\n%\nT1\nX1234Y2345\nX6321Y2932\nM30\n";
  EXPECT_EQ(read(program, reading).diagnostics, Lines{"p.exc:7:1: error[format-ambiguous]"});
}

TEST(FormatChoice, AJobIsLargerThanATenthOfAMillimetre) {
  EXPECT_EQ(summary("M48\nINCH\nT1C.25\n%\nT1\nX11Y12\nX13Y21\nM30\n"),
            "inch 2.4, leading zeros kept");
}

TEST(FormatChoice, StepsDoNotShowHowFarAJobExtends) {
  EXPECT_EQ(read("M48\nINCH\nT1C.25\n%\nG91\nT1\nX11Y12\nX13Y21\nM30\n").diagnostics,
            Lines{"p.exc:7:1: error[format-ambiguous]"});
}

/// gerbv's example of VeriBest's output, in short: only the body states the unit, behind the tools.
TEST(FormatChoice, ReadsTheToolsInTheUnitOfTheBodyWhereNoDrillHasThemInTheOther) {
  const Read out = read(
      "M48\nT01C.864\nT02C1.092\nR,H\n/\n%\nG90\nM71\nG93X000000Y000000\nG05\nT01\nX40500Y6270\n"
      "Y3730\nX37000Y8960\nX76461\nM30\n");
  EXPECT_EQ(out.header.format.summary(), "metric 3.3, trailing zeros kept");
  EXPECT_DOUBLE_EQ(out.header.tools.at(1).diameter->in_mm(), 0.864);
}

TEST(FormatChoice, LeavesAUnitLateWhereTheToolsFitBoth) {
  const Read out = read("M48\nT01C.1\n%\nM71\nT01\nX040500Y006270\nM30\n");
  EXPECT_EQ(out.header.format.unit, LengthUnit::Inch);  // its line is refused when it is executed
}

// --- what is stated elsewhere --------------------------------------------------------------------

TEST(FormatChoice, TheLastSettingDecidesWithoutAWarning) {
  const ReadOptions reading{
      .last_format = {LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(4, 2), "[program]"}};
  const Read out = read("T1\nX100Y2000\nX300Y400\nM30\n", reading);
  EXPECT_EQ(out.diagnostics, Lines{});
  EXPECT_EQ(out.header.number_summary(), "metric 4.2, trailing zeros kept");
  EXPECT_EQ(out.header.format_evidence, "[program]");
  EXPECT_EQ(summary("M48\nMETRIC,LZ\n%\nM30\n", reading), "metric 4.2, leading zeros kept");
  EXPECT_EQ(summary("M48\nINCH,LZ\n%\nM30\n", reading), "inch 2.4, leading zeros kept");
}

TEST(FormatChoice, TheFileBesideTheProgramRulesOverTheLastSetting) {
  const ReadOptions reading{
      .format_beside = {LengthUnit::Millimeter, {}, std::pair(2, 5), "nc_param.txt"},
      .last_format = {LengthUnit::Inch, Zeros::TrailingKept, std::pair(2, 4), "[program]"}};
  EXPECT_EQ(summary("T1\nX4890000Y3835000\nM30\n", reading), "metric 2.5, trailing zeros kept");
}

TEST(FormatChoice, TheOperatorRulesOverTheHeaderAndItsComments) {
  const ReadOptions reading{.forced_format = *parse_format("inch,tz,2.4")};
  EXPECT_EQ(summary("M48\nMETRIC,LZ,000.00\n;FILE_FORMAT=3:3\n%\nM30\n", reading),
            "inch 2.4, trailing zeros kept");
  EXPECT_EQ(read("M48\nT1C0.8\nINCH,TZ\n%\nM30\n", reading).diagnostics, Lines{});
  const ReadOptions metric{.forced_format = *parse_format("metric")};
  for (const char* lines : {"INCH,TZ\n;FILE_FORMAT=4:4\n", ";FILE_FORMAT=4:4\nINCH,TZ\n"}) {
    EXPECT_EQ(summary(std::string("M48\n") + lines + "%\nM30\n", metric),
              "metric 4.4, trailing zeros kept");
  }
  EXPECT_EQ(summary("M48\nINCH,TZ\n%\nM30\n", metric), "metric 3.3, trailing zeros kept");
  const ReadOptions zeros_only{.forced_format = *parse_format("tz")};
  EXPECT_EQ(summary("M48\nMETRIC,LZ,000.00\n%\nM30\n", zeros_only),
            "metric 3.2, trailing zeros kept");
  EXPECT_EQ(summary("M48\nR,H\n%\nT1\nMETRIC,LZ\nX1000Y2000\nM30\n", zeros_only),
            "metric 3.3, trailing zeros kept");
}

}  // namespace
}  // namespace panelcal::excellon
