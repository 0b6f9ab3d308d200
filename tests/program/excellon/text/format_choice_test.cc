// SPDX-License-Identifier: Apache-2.0
// A program that leaves its number format open is read in the one that its numbers can be meant in,
// or not at all.
#include "program/excellon/text/format_choice.h"

#include <string>
#include <utility>
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

/// As a whole trailing zeros, for 90 inch are beyond any panel. Of the first holes alone, leading
/// ones. What comes behind the end is a comment.
TEST(FormatChoice, RefusesToLetNumbersDecideWhereTheEndIsMissing) {
  const std::string whole =
      "M48\nINCH\nT1C0.04F100\n%\nT1\nX10Y10\nX30Y20\nX50Y10\nX90Y10\nX12345Y10000\nX20Y15\nM30\n";
  const ReadOptions accepting{.accepts_unterminated = true};
  for (const std::string& text : {whole, whole + ";LEADER\n\n"}) {
    EXPECT_EQ(read(text, accepting).diagnostics, Lines{"p.exc:6:1: warning[format-assumed]"});
  }
  for (const std::string last : {"X30Y20\n", "X90Y10\n", "X12345Y10000\n", "X20Y15\n"}) {
    const std::string cut = whole.substr(0, whole.find(last) + last.size());
    const Read out = read(cut, accepting);
    EXPECT_EQ(out.diagnostics, Lines{"p.exc:6:1: error[format-ambiguous]"}) << cut;
    EXPECT_TRUE(out.header.is_refused) << cut;
  }
}

TEST(FormatChoice, RefusesWhatCanBeMeantInInchAndInMetric) {
  const Read out = read("T1\nX01Y02\nX03Y04\nM30\n");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:2:1: error[format-ambiguous]"});
  EXPECT_TRUE(out.header.is_refused);
  EXPECT_THAT(out.text,
              HasSubstr("inch 2.4, leading zeros kept (x 25.4 to 76.2, y 50.8 to 101.6 mm)"));
  EXPECT_THAT(out.text, HasSubstr("metric 3.3, leading zeros kept (x 10 to 30, y 20 to 40 mm)"));
}

/// A control in metric has 000.000, 0000.00 or 000.00 (CNC-7 manual, Inch vs. Metric).
TEST(FormatChoice, RefusesMetricDigitsThatNothingDecides) {
  const Read out = read("M48\nT1C.8\n%\nT1\nX012345Y023456\nX01Y013\nM30\n");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: error[format-ambiguous]"});
  EXPECT_THAT(out.text, HasSubstr("metric 3.3, leading zeros kept (x 10 to 12.3"));
  EXPECT_THAT(out.text, HasSubstr("metric 4.2, leading zeros kept (x 100 to 123."));
}

TEST(FormatChoice, TakesTheMetricDigitsOfAUnitThatIsStated) {
  const Read out = read("M48\nMETRIC\n%\nT1\nX012345Y023456\nX06Y013\nM30\n");
  EXPECT_EQ(out.header.number_summary(), "metric 3.3, leading zeros kept");
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
  EXPECT_EQ(out.header.format().unit, LengthUnit::Inch);
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
  EXPECT_EQ(read(wide).header.format().zeros, Zeros::LeadingKept);
  EXPECT_THAT(read(wide, {.travel_mm = {{500, 500}}}).diagnostics,
              testing::ElementsAre("p.exc:5:1: error[format-ambiguous]"));
}

TEST(FormatChoice, TravelDecidesOnMetricDigits) {
  const ReadOptions reading{.travel_mm = {{500, 500}}};
  const Read out = read("M48\nT1C.8\n%\nT1\nX012345Y023456\nX01Y013\nX12Y01\nM30\n", reading);
  EXPECT_EQ(out.header.number_summary(), "metric 3.3, leading zeros kept");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: warning[format-assumed]"});
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
  EXPECT_EQ(out.header.format().summary(), "metric 3.3, trailing zeros kept");
  EXPECT_DOUBLE_EQ(out.header.tools.at(1).diameter->in_mm(), 0.864);
}

TEST(FormatChoice, LeavesAUnitLateWhereTheToolsFitBoth) {
  const Read out = read("M48\nT01C.1\n%\nM71\nT01\nX040500Y006270\nM30\n");
  EXPECT_EQ(out.header.format().unit, LengthUnit::Inch);  // its line is refused when it is executed
}

// --- what is stated elsewhere --------------------------------------------------------------------

TEST(FormatChoice, TheLastSettingDecidesWithoutAWarning) {
  const ReadOptions reading{
      .last_format = {LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(4, 2), "[program]"}};
  const Read out = read("T1\nX100Y2000\nX300Y400\nM30\n", reading);
  EXPECT_EQ(out.diagnostics, Lines{});
  EXPECT_EQ(out.header.number_summary(), "metric 4.2, trailing zeros kept");
  EXPECT_EQ(out.header.format_evidence(), "[program]");
  EXPECT_EQ(summary("M48\nMETRIC,LZ\n%\nM30\n", reading), "metric 4.2, leading zeros kept");
  EXPECT_EQ(summary("M48\nINCH,LZ\n%\nM30\n", reading), "inch 2.4, leading zeros kept");
}

/// A control takes the digits that were selected last (CNC-7 manual, Metric Measuring Mode), and
/// METRIC alone stands for 000.000 in nearly all files.
TEST(FormatChoice, WarnsOfDigitsThatAUnitTakesFromElsewhere) {
  const ReadOptions reading{.last_format = {{}, Zeros::TrailingKept, std::pair(4, 2), "[program]"}};
  const Read out = read("M48\nMETRIC,TZ\n%\nT1\nX1234Y2345\nM30\n", reading);
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: warning[format-assumed]"});
  EXPECT_THAT(out.text, HasSubstr("metric 4.2, trailing zeros kept ([program])"));
  EXPECT_THAT(out.text, HasSubstr("the usual digits are metric 3.3, trailing zeros kept"));
  EXPECT_EQ(out.header.number_summary(), "metric 4.2, trailing zeros kept");
  EXPECT_EQ(out.header.format_evidence(), "line 2: METRIC,TZ; [program]");
  EXPECT_THAT(out.text, HasSubstr("such as METRIC,TZ,000.000"));
  const Lines in_the_body{"p.exc:3:1: warning[format-assumed]"};
  EXPECT_EQ(read("M71\nT1\nX1234Y2345\nM30\n", reading).diagnostics, in_the_body);
}

TEST(FormatChoice, NamesTheDigitsOfTheProgramsUnit) {
  const ReadOptions reading{
      .last_format = {LengthUnit::Inch, Zeros::TrailingKept, std::pair(2, 3), "[program]"}};
  const Read trailing = read("M48\nINCH,TZ\n%\nT1\nX1234Y2345\nM30\n", reading);
  EXPECT_EQ(trailing.diagnostics, Lines{"p.exc:5:1: warning[format-assumed]"});
  EXPECT_THAT(trailing.text, HasSubstr("such as INCH,TZ,00.0000"));
}

TEST(FormatChoice, WarnsOfNoDigitsThatAreStatedOrMakeNoDifference) {
  const ReadOptions reading{.last_format = {{}, Zeros::TrailingKept, std::pair(4, 2), "[program]"}};
  for (const char* head :
       {"METRIC,TZ,0000.00\n", "METRIC,TZ,000.000\n", ";FILE_FORMAT=3:3\nM71\n"}) {
    EXPECT_EQ(read(std::string("M48\n") + head + "%\nT1\nX1234Y2345\nM30\n", reading).diagnostics,
              Lines{})
        << head;
  }
  EXPECT_EQ(read("M48\nMETRIC,TZ\n%\nT1\nX1.234Y0\nM30\n", reading).diagnostics, Lines{});
  EXPECT_EQ(read("T1\nX1234Y2345\nM30\n",
                 {.last_format =
                      {LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(4, 2), "[program]"}})
                .diagnostics,
            Lines{});
  // Under LZ digits behind the point say nothing of a value.
  const ReadOptions tenths{.last_format = {{}, Zeros::LeadingKept, std::pair(3, 2), "[program]"}};
  EXPECT_EQ(read("M48\nMETRIC,LZ\n%\nT1\nX01234Y02345\nM30\n", tenths).diagnostics, Lines{});
}

ReadOptions with_unreadable_file_beside() {
  ReadOptions reading{
      .last_format = {LengthUnit::Inch, Zeros::LeadingKept, std::pair(2, 4), "[program]"}};
  reading.format_beside.file = "nc_param.txt";
  reading.format_beside.fault =
      Diagnostic{Code::ArgumentInvalid, {"nc_param.txt", 1, 1}, "\"INTEGER-PLACES two\"", ""};
  return reading;
}

/// The file might say otherwise than [program], so that nothing decides.
TEST(FormatChoice, RefusesAProgramThatNeedsAFileBesideItThatCannotBeRead) {
  const ReadOptions reading = with_unreadable_file_beside();
  for (const char* text : {"T1\nX1.0Y1.0\nM30\n",
                           "T1C.02\nX01Y02\nX03Y04\nM30\n",
                           "M48\nMETRIC\n%\nT1\nX1234Y2345\nM30\n"}) {
    const Read out = read(text, reading);
    EXPECT_EQ(out.diagnostics, Lines{"nc_param.txt:1:1: error[argument-invalid]"}) << text;
    EXPECT_TRUE(out.header.is_refused) << text;
  }
}

TEST(FormatChoice, ReadsAProgramThatNeedsNoFileBesideIt) {
  const ReadOptions reading = with_unreadable_file_beside();
  for (const char* text : {"M48\nMETRIC,TZ,000.000\n%\nT1\nX1234Y2345\nM30\n",
                           "M48\nMETRIC\n%\nT1\nX1.234Y0\nM30\n",
                           "T1\nX0Y0\nM30\n",
                           "T1\nMETRIC,LZ\nX1.0Y1.0\nM30\n"}) {
    EXPECT_EQ(read(text, reading).diagnostics, Lines{}) << text;
  }
  ReadOptions forced = reading;
  forced.forced_format = *parse_format("metric,tz,3.3");
  EXPECT_EQ(read("T1\nX1234Y2345\nM30\n", forced).diagnostics, Lines{});
}

/// By the manual METRIC is 000.000, and the file may say otherwise.
TEST(FormatChoice, RefusesBareNumbersWhoseDigitsAFileMayStateThatCannotBeRead) {
  for (const char* text : {"M48\nMETRIC,TZ\n%\nT1\nX1234Y2345\nM30\n",
                           "M48\nMETRIC,TZ\n%\nT1\nX1.5Y2.5\nDN,05\nM30\n"}) {
    const Read out = read(text, with_unreadable_file_beside());
    EXPECT_EQ(out.diagnostics, Lines{"nc_param.txt:1:1: error[argument-invalid]"}) << text;
    EXPECT_TRUE(out.header.is_refused) << text;
  }
}

ReadOptions with_steps_beside(PartialFormat format = {}) {
  ReadOptions reading;
  reading.format_beside.format = std::move(format);
  reading.format_beside.file = "nc_param.txt";
  reading.format_beside.steps = Diagnostic{Code::NotSupported, {"nc_param.txt", 7, 1}, "", ""};
  return reading;
}

/// COORDINATES INCREMENTAL: places would be others, and the manual's default is absolute.
TEST(FormatChoice, RefusesStepsThatOnlyTheFileBesideItStates) {
  const Lines refused{"nc_param.txt:7:1: error[not-supported]"};
  const ReadOptions alone = with_steps_beside();
  for (const char* text : {"M48\nMETRIC,TZ\n%\nT1\nX5000Y5000\nX10000Y12000\nM30\n",
                           "M48\nMETRIC,000.000\n%\nT1\nX5000Y5000\nM30\n",
                           "M48\nT1C0.8\n%\nT1\nX5.0Y5.0\nM30\n",
                           "M48\nMETRIC,TZ,000.000\n%\nT1\nX5000Y5000\nM30\n",
                           "M48\nMETRIC\n%\nT1\nX5.0Y5.0\nM30\n"}) {
    EXPECT_EQ(read(text, alone).diagnostics, refused) << text;
    EXPECT_TRUE(read(text, alone).header.is_refused) << text;
  }
  const ReadOptions whole = with_steps_beside(
      {LengthUnit::Millimeter, Zeros::TrailingKept, std::pair(2, 5), "nc_param.txt"});
  EXPECT_EQ(read("T1\nX5.0Y5.0\nM30\n", whole).diagnostics, refused);
  EXPECT_EQ(read("M71\nT1\nX500000Y5.0\nM30\n", whole).diagnostics, refused);
}

/// No part of a number format says whether coordinates are steps.
TEST(FormatChoice, LeavesStepsOfAFileOutWhereTheProgramOrAWholeOptionDecides) {
  const ReadOptions reading = with_steps_beside();
  const std::string open = "%\nT1\nX5000Y5000\nM30\n";
  for (const char* head : {"M48\nMETRIC,TZ\nICI,OFF\n",
                           "M48\nMETRIC,TZ\nG90\n",
                           "; Format : 3.3 / Absolute / MM / Leading\nM48\n"}) {
    EXPECT_EQ(read(head + open, reading).diagnostics, Lines{}) << head;
  }
  for (const char* steps : {"G91\n", "G90\n", "ICI,ON\n"}) {
    const std::string text = std::string("M48\nMETRIC,TZ\n%\nT1\n") + steps + "X5000Y5000\nM30\n";
    EXPECT_EQ(read(text, reading).diagnostics, Lines{}) << steps;
  }
  ReadOptions forced = reading;
  forced.forced_format = *parse_format("metric,tz,3.3");
  EXPECT_EQ(read("T1\nX5000Y5000\nM30\n", forced).diagnostics, Lines{});
  forced.forced_format = *parse_format("metric,3.3");
  EXPECT_EQ(read("M48\nMETRIC,TZ\n%\nT1\nX5000Y5000\nM30\n", forced).diagnostics,
            Lines{"nc_param.txt:7:1: error[not-supported]"});
}

/// Zeros of a control in inch say little of a program in metric.
TEST(FormatChoice, WarnsOfZerosOfTheLastSettingInAnotherUnit) {
  const ReadOptions reading{
      .last_format = {LengthUnit::Inch, Zeros::LeadingKept, std::pair(2, 4), "[program]"}};
  const Read out = read("M48\nMETRIC\n%\nT1\nX1.0Y0\nX5000Y5000\nM30\n", reading);
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:6:1: warning[format-assumed]"});
  EXPECT_THAT(out.text,
              HasSubstr("\"X5000\" is read as metric 3.3, leading zeros kept; the zeros are those "
                        "of [program], in inch"));
  for (const char* text : {"M48\nMETRIC,TZ\n%\nT1\nX5000Y5000\nM30\n",
                           "M48\nMETRIC\n%\nT1\nX005000Y005000\nM30\n",
                           "M48\nMETRIC\n%\nT1\nX5.0Y5.0\nM30\n",
                           "M48\nINCH\n%\nT1\nX5000Y5000\nM30\n",
                           "T1\nX5000Y5000\nM30\n"}) {
    EXPECT_EQ(read(text, reading).diagnostics, Lines{}) << text;
  }
}

/// Digits as METRIC has them anyway are no others, whoever states them.
TEST(FormatChoice, SaysNothingOfTheUsualDigitsInTheLastSetting) {
  const ReadOptions reading{.last_format = {{}, {}, std::pair(3, 3), "[program]"}};
  const auto untouched = [](std::string_view) -> std::vector<std::string> {
    ADD_FAILURE() << "the numbers are not looked at";
    return {};
  };
  DiagnosticLog log;
  read_header(
      {"p.exc", "M48\nMETRIC,TZ\n%\nT1\nX1000Y2000\nM99,PAT\nX1\nM30\n"}, reading, log, untouched);
  EXPECT_EQ(test::briefs(log), Lines{});
}

TEST(FormatChoice, TheFileBesideTheProgramRulesOverTheLastSetting) {
  const ReadOptions reading{
      .format_beside = {.format = {LengthUnit::Millimeter, {}, std::pair(2, 5), "nc_param.txt"},
                        .file = "nc_param.txt",
                        .fault = {},
                        .steps = {}},
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
