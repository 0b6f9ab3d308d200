// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>
#include <vector>

#include "program/excellon/text/header_reader.h"
#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

struct ReadHeader {
  SourceText source;
  Header header;
  std::vector<std::string> diagnostics;  ///< without their wording
  std::vector<std::string> texts;

  std::string first_body_line() const {
    LineCursor body(source.bytes, header.body);
    return body.at_end() ? "" : std::string(body.next().text);
  }
};

ReadHeader read(std::string text,
                const ReadOptions& reading = {.last_format = test::last_set_to_inch()}) {
  DiagnosticLog log;
  ReadHeader out{{"p.exc", std::move(text)}, {}, {}};
  out.header = read_header(out.source, reading, log);
  out.diagnostics = test::briefs(log);
  for (const Diagnostic& diagnostic : log.kept()) out.texts.push_back(diagnostic.text());
  return out;
}

NumberFormat format_of(const std::string& lines) {
  const ReadHeader out = read("M48\n" + lines + "%\n");
  EXPECT_TRUE(out.diagnostics.empty()) << out.diagnostics.front();
  return out.header.format();
}

using Texts = std::vector<std::string>;

// --- where it begins and ends --------------------------------------------------------------------

TEST(Header, EndsWithPercentOrM95) {
  EXPECT_EQ(read("M48\nINCH,LZ\n%\nG05\n").first_body_line(), "G05");
  EXPECT_EQ(read("M48\nINCH,LZ\nM95\nG05\n").first_body_line(), "G05");
}

TEST(Header, CommentsAndBlankLinesAreAllowed) {
  const ReadHeader out = read("; made today\n\nM48\n; hello\n\nINCH,TZ\n%\nG05\n");
  EXPECT_EQ(out.diagnostics, Texts{});
  EXPECT_EQ(out.header.format().zeros, Zeros::TrailingKept);
}

TEST(Header, NamesTheDigitsOfItsUnitWhereAnOptionIsWrong) {
  EXPECT_THAT(read("M48\nINCH,LX\n%\nG05\n").texts,
              testing::ElementsAre(testing::HasSubstr("digits such as 00.0000")));
  EXPECT_THAT(read("M48\nMETRIC,LX\n%\nG05\n").texts,
              testing::ElementsAre(testing::HasSubstr("digits such as 000.000")));
}

TEST(Header, WithoutM48TheBodyBeginsAtTheFirstLine) {
  EXPECT_EQ(read("T1\nX01\n").first_body_line(), "T1");
}

TEST(Header, APercentInFrontOfAHeaderlessBodyIsARewindStop) {
  EXPECT_EQ(read("%\nT1\n").first_body_line(), "T1");
  EXPECT_EQ(read("%\n%\nX01\nM01\n").first_body_line(), "%");
}

TEST(Header, APercentMayStandBeforeM48) {
  const ReadHeader out = read("%\nM48\nMETRIC,TZ\n%\nT1\n");
  EXPECT_EQ(out.diagnostics, Texts{});
  EXPECT_EQ(out.header.format().unit, LengthUnit::Millimeter);
  EXPECT_EQ(out.first_body_line(), "T1");
}

TEST(Header, TheBodyKnowsItsLineNumber) {
  EXPECT_EQ(read("M48\nINCH,LZ\n%\nG05\n").header.body.number, 4);
  EXPECT_EQ(read("; made today\nG05\n").header.body.number, 2);
}

TEST(Header, SaysWhereAnOpenHeaderBegan) {
  EXPECT_EQ(read("\nM48\nINCH,LZ\n").diagnostics, Texts{"p.exc:2:1: error[header-unclosed]"});
}

// --- commands outside of it ----------------------------------------------------------------------

/// "If you choose not to use a header, then you must either write the commands into the part
/// program or enter them at the CNC-7 console."
TEST(Header, CommandsBeforeTheFirstBlockAreAHeader) {
  const ReadHeader out = read("; by hand\nINCH,TZ\nVER,3\nG90\nICI,ON\nATC,ON\nT1C.04\nX1\n");
  EXPECT_EQ(out.header.format().summary(), "inch 2.4, trailing zeros kept");
  EXPECT_TRUE(out.header.stated.states_unit() && out.header.stated.states_zeros() &&
              out.header.incremental);
  EXPECT_EQ(out.header.axis_version, 3);
  EXPECT_EQ(out.header.settings.back().text, "ATC,ON");
  EXPECT_EQ(out.first_body_line(), "T1C.04");
  EXPECT_EQ(out.header.body.number, 7);
  EXPECT_EQ(out.diagnostics,  // none for G90, a command of the body
            (Texts{"p.exc:2:1: warning[header-word-in-body]",
                   "p.exc:3:1: warning[header-word-in-body]",
                   "p.exc:5:1: warning[header-word-in-body]",
                   "p.exc:6:1: warning[header-word-in-body]"}));
}

TEST(Header, CommandsBehindItAreReadWithIt) {
  const ReadHeader out = read("M48\nMETRIC,LZ\n%\nM71\nVER,2\nMETRIC,LZ\nMETRIC\nT1\n");
  EXPECT_EQ(out.diagnostics, Texts{"p.exc:5:1: warning[header-word-in-body]"});
  EXPECT_EQ(out.header.axis_version, 2);
  EXPECT_EQ(out.header.end_line, 3);
  EXPECT_EQ(out.first_body_line(), "T1");
}

TEST(Header, SetUpWordsWithoutACommandBehindThemAreTheBody) {
  EXPECT_EQ(read("G90\nM72\nT1\n").first_body_line(), "G90");
  EXPECT_EQ(read("M48\nINCH\n%\nG91\nT1\n").first_body_line(), "G91");
  EXPECT_EQ(read("CAN_TEXT_OFF,1\nT1\n").first_body_line(), "CAN_TEXT_OFF,1");
  EXPECT_EQ(read("1/2\nINCH,LZ\n").first_body_line(), "1/2");
}

/// gerbv's example ekf2.
TEST(Header, MayStandBehindSetUpWordsAndComeTwice) {
  const ReadHeader out = read("G90\nM72\nM48\nT7C0.035\n%\nG90\nM72\nM48\n%\nT7\n");
  EXPECT_EQ(out.header.format().unit, LengthUnit::Inch);
  EXPECT_TRUE(out.header.stated.states_unit());
  EXPECT_EQ(out.header.tools.size(), 1U);
  EXPECT_EQ(out.header.end_line, 9);
  EXPECT_EQ(out.first_body_line(), "T7");
  EXPECT_EQ(out.diagnostics, Texts{"p.exc:8:1: warning[header-word-in-body]"});
}

/// "When the options in the part program body are different from the options in the header or
/// console, the body options are not used."
TEST(Header, AnotherOptionBehindItIsRefused) {
  for (const char* other : {"METRIC,TZ", "INCH", "VER,2", "ATC,OFF", "ICI,OFF"}) {
    const ReadHeader out =
        read("M48\nMETRIC,LZ\nVER,1\nATC,ON\nICI,ON\n%\n" + std::string(other) + "\nT1\n");
    EXPECT_THAT(out.diagnostics, testing::Contains("p.exc:7:1: error[argument-invalid]")) << other;
  }
}

TEST(Header, AnOptionMayComeAgainInAnotherSpelling) {
  for (const char* again : {"METRIC,TZ", "METRIC,TZ,000.000", "METRIC,000.000", "METRIC", "ICI"}) {
    const ReadHeader out =
        read("M48\nMETRIC,000.000,TZ\nICI,ON\n%\n" + std::string(again) + "\nT1\n");
    EXPECT_EQ(out.diagnostics, Texts{}) << again;
  }
  const ReadHeader more = read("M48\nINCH\n%\nINCH,TZ\nT1\n");
  EXPECT_EQ(more.diagnostics, Texts{"p.exc:4:1: warning[header-word-in-body]"});
  EXPECT_EQ(more.header.format().zeros, Zeros::TrailingKept);
  EXPECT_THAT(read("M48\nICI\n%\nICI,OFF\nT1\n").texts.at(0),
              testing::HasSubstr("\"ICI,OFF\" behind \"ICI\";"));
}

TEST(Header, BlanksInACommandHaveNoMeaning) {
  const ReadHeader out = read("M48\nMETRIC, TZ ,000.00\nFOO BAR\n%\n");
  EXPECT_EQ(out.header.format().summary(), "metric 3.2, trailing zeros kept");
  EXPECT_EQ(
      out.diagnostics,
      (Texts{"p.exc:2:1: warning[notation-accepted]", "p.exc:3:1: error[header-word-unknown]"}));
}

// --- number format -------------------------------------------------------------------------------

TEST(Header, ManualDefaultIsInchWithLeadingZeros) {
  const ReadHeader out = read("M48\n%\n");
  EXPECT_EQ(out.header.format().summary(), "inch 2.4, leading zeros kept");
  EXPECT_FALSE(out.header.stated.states_unit());
}

TEST(Header, DigitsOfACommentBelongToItsUnit) {
  const std::string metric = "; Format : 3.3 / Absolute / MM / Leading\n";
  const std::string inch = "; Format : 2.4 / Absolute / Inch / Trailing\n";
  EXPECT_EQ(read(metric + "M48\nINCH,TZ\n%\n").header.format().summary(),
            "inch 2.4, trailing zeros kept");
  EXPECT_EQ(format_of("METRIC,TZ\n" + inch).summary(), "metric 3.3, trailing zeros kept");
  EXPECT_EQ(read(metric + inch + "M48\n%\n").diagnostics,
            Texts{"p.exc:2:1: error[argument-invalid]"});
}

TEST(Header, InchAndMetricStateTheFormat) {
  EXPECT_EQ(format_of("INCH\n").summary(), "inch 2.4, leading zeros kept");
  EXPECT_EQ(format_of("INCH,TZ\n").summary(), "inch 2.4, trailing zeros kept");
  EXPECT_EQ(format_of("METRIC,LZ\n").summary(), "metric 3.3, leading zeros kept");
  EXPECT_EQ(format_of("METRIC,TZ,0000.00\n").summary(), "metric 4.2, trailing zeros kept");
  EXPECT_EQ(format_of("METRIC,000.00\n").summary(), "metric 3.2, leading zeros kept");
  EXPECT_TRUE(read("M48\nMETRIC\n%\n").header.stated.states_unit());
}

TEST(Header, CommentHintsGiveDigitsZerosAndUnit) {
  EXPECT_EQ(format_of(";FILE_FORMAT=4:4\nMETRIC,LZ\n").summary(), "metric 4.4, leading zeros kept");
  EXPECT_EQ(format_of("; FORMAT={3:3/ absolute / metric / suppress leading zeros}\n").summary(),
            "metric 3.3, trailing zeros kept");
  EXPECT_EQ(format_of("; FORMAT={2:4/ absolute / inch / suppress trailing zeros}\n").summary(),
            "inch 2.4, leading zeros kept");
  EXPECT_EQ(format_of("; FORMAT={-:-/ absolute / metric / decimal}\n").summary(),
            "metric 3.3, leading zeros kept");
}

TEST(Header, TheStatedUnitRulesOverAComment) {
  EXPECT_EQ(format_of("METRIC,TZ\n;FORMAT={3:3/ absolute / inch / suppress leading zeros}\n").unit,
            LengthUnit::Millimeter);
  EXPECT_EQ(format_of(";FORMAT={3:3/ absolute / inch / suppress leading zeros}\nMETRIC,TZ\n").unit,
            LengthUnit::Millimeter);
}

TEST(Header, CommentsThatOnlyLookLikeHintsAreIgnored) {
  for (const char* hint : {";FILE_FORMAT=",
                           ";FILE_FORMAT=4:",
                           ";FILE_FORMAT=0:0",
                           ";FILE_FORMAT=9:9",
                           ";FORMAT={",
                           ";FORMAT={}",
                           ";FORMAT={3:3",
                           "; METRIC"}) {
    const NumberFormat format = format_of(std::string(hint) + "\nINCH\n");
    EXPECT_EQ(format.unit, LengthUnit::Inch) << hint;
  }
}

/// "The INCH/METRIC command must be specified before any commands with dimensions."
TEST(Header, AUnitBehindNumbersThatItMeasuresIsRefused) {
  for (const char* number : {"T1C.8",
                             "T1F200",
                             "T1Z-.1",
                             "CP,1,.8",
                             "Z,X1.Y1.",
                             "ZC,X1.Y1.",
                             "CAN_TEXT_OFF,1.",
                             "DN,.5",
                             "Z-.1"}) {
    for (const char* unit : {"METRIC", "M71", ";FORMAT={3:3/ absolute / metric}"}) {
      EXPECT_EQ(read("M48\n" + std::string(number) + "\n" + unit + "\n%\n").diagnostics,
                Texts{"p.exc:3:1: error[argument-invalid]"})
          << number << ' ' << unit;
    }
  }
  EXPECT_EQ(read("M48\nT1S65H20\nATC,ON\nMETRIC\n%\n").diagnostics, Texts{});
}

TEST(Header, DigitsAndZerosBehindNumbersThatTheyDecideAreRefused) {
  const Texts late{"p.exc:4:1: error[argument-invalid]"};
  const auto read_behind = [](const char* unit, const char* number, const char* statement) {
    const std::string head = std::string("M48\n") + unit + "\n" + number + "\n";
    return read(head + statement + "\n%\n").diagnostics;
  };
  constexpr const char* kTrailing = ";FORMAT={3:3/ absolute / metric / suppress leading zeros}";
  for (const auto& [unit, statement] : {std::pair("METRIC,TZ", ";FILE_FORMAT=3:4"),
                                        std::pair("METRIC,TZ", "METRIC,000.00"),
                                        std::pair("METRIC,LZ", ";FILE_FORMAT=4:4"),
                                        std::pair("METRIC", kTrailing)}) {
    EXPECT_EQ(read_behind(unit, "T1C800", statement), late) << unit << statement;
    EXPECT_EQ(read_behind(unit, "T1C.8", statement), Texts{}) << unit << statement;
    for (const char* composite : {"CP,1,05", "ZC,X1.0Y2000", "CAN_TEXT_OFF,1.0,2000"}) {
      EXPECT_EQ(read_behind(unit, composite, statement), late) << unit << composite;
    }
  }
  EXPECT_EQ(read_behind("METRIC,TZ", "T1C800", ";FILE_FORMAT=3:3"), Texts{});
  EXPECT_EQ(read_behind("METRIC", "T1C.8", "METRIC,TZ"), Texts{});
  EXPECT_EQ(read_behind("METRIC", "T1C8", "METRIC,TZ"),
            Texts{"p.exc:4:8: error[argument-invalid]"});
  // Under LZ digits behind the point change no number.
  EXPECT_EQ(read_behind("METRIC,LZ", "T1C08", ";FILE_FORMAT=3:4"), Texts{});
}

/// Numbers of the body are read by what stands before them; outputs state their unit at once.
TEST(Header, OutputsHaveTheUnitThatTheBodyStates) {
  const ReadHeader out = read("T1\nM47,METRICAL\nMETRIC,TZ\nX1000Y1000\n");
  EXPECT_EQ(out.header.format().summary(), "inch 2.4, leading zeros kept");
  EXPECT_EQ(out.header.number_format().summary(), "metric 3.3, trailing zeros kept");
  EXPECT_EQ(out.header.format_evidence(), "line 3: METRIC,TZ");
  EXPECT_EQ(read("T1\nM71\nX1.\n").header.number_format().unit, LengthUnit::Millimeter);
  EXPECT_EQ(read("T1\nX1.\nM71\n").header.number_format().unit, LengthUnit::Inch);
  EXPECT_EQ(read("T1\nM45,a\\\nMETRIC\nX1.\n").header.number_format().unit, LengthUnit::Inch);
  EXPECT_EQ(read("M48\nMETRIC\n%\nT1\nM72\nX1.\n").header.number_format().unit,
            LengthUnit::Millimeter);
}

/// A unit that a comment has stated before them is not late.
TEST(Header, AUnitMayRepeatThatOfACommentBehindNumbers) {
  const std::string comment = ";FORMAT={3:3/ absolute / metric / suppress leading zeros}\n";
  EXPECT_EQ(read("M48\n" + comment + "T1C.8\nMETRIC,TZ\n%\n").diagnostics, Texts{});
  EXPECT_EQ(read("M48\n" + comment + "T1C.8\nINCH,TZ\n%\n").diagnostics,
            Texts{"p.exc:4:1: error[argument-invalid]"});
}

/// Digits that a unit takes from elsewhere are not those of an output, which states the unit alone.
TEST(Header, DeclaresTheDigitsThatItStatesOrLeavesOpenWithItsUnit) {
  const ReadOptions reading{
      .last_format = {LengthUnit::Millimeter, Zeros::LeadingKept, std::pair(3, 2), "[program]"}};
  EXPECT_FALSE(read("M48\nMETRIC,LZ\n%\n", reading).header.declares_digits());
  EXPECT_TRUE(read("M48\nMETRIC,LZ,000.00\n%\n", reading).header.declares_digits());
  EXPECT_TRUE(read("M48\n;FILE_FORMAT=3:2\nMETRIC\n%\n", reading).header.declares_digits());
  EXPECT_TRUE(read("T1\nX01\n", reading).header.declares_digits());
  EXPECT_FALSE(read("M48\n%\n", {}).header.declares_digits());
}

TEST(Header, SaysWhichLineStatedTheFormat) {
  EXPECT_EQ(read("M48\n\nMETRIC,TZ\n%\n").header.format_evidence(), "line 3: METRIC,TZ");
  EXPECT_EQ(read("M48\nM71\n%\n").header.format_evidence(), "line 2: M71");
  EXPECT_EQ(read("M48\nMETRIC,0000.00\nMETRIC,TZ\n%\n").header.format_evidence(),
            "line 2: METRIC,0000.00; line 3: METRIC,TZ");
  EXPECT_EQ(read(";FILE_FORMAT=4:4\nM48\n%\n").header.format_evidence(),
            "line 1: ;FILE_FORMAT=4:4");
}

TEST(Header, NamesABadFormatWordAndItsColumn) {
  EXPECT_EQ(read("M48\nMETRIC,TZ,00X\n%\n").diagnostics,
            Texts{"p.exc:2:11: error[argument-invalid]"});
}

// --- switches, tools, settings -------------------------------------------------------------------

TEST(Header, SwitchesChangeHowTheBodyIsRead) {
  const ReadHeader on = read("M48\nICI,ON\nBLKD,ON\n%\n");
  EXPECT_TRUE(on.header.incremental);
  EXPECT_TRUE(on.header.block_delete.value_or(false));
  const ReadHeader off = read("M48\nICI,OFF\nBLKD,OFF\n%\n");
  EXPECT_FALSE(off.header.incremental);
  EXPECT_FALSE(off.header.block_delete.value_or(false));
  EXPECT_TRUE(read("M48\nICI\n%\n").header.incremental);
  EXPECT_EQ(read("M48\nICI,MAYBE\n%\n").diagnostics, Texts{"p.exc:2:5: error[argument-invalid]"});
}

TEST(Header, PassesMachineSettingsOnInOrder) {
  const ReadHeader out = read("M48\nR,C\n1/5/6\n ATC,ON\n/\nVER,1\nFMAT,2\n%\n");
  EXPECT_EQ(out.diagnostics, Texts{});
  Texts texts;
  for (const HeaderSetting& setting : out.header.settings) {
    texts.push_back(std::to_string(setting.line) + " " + setting.text);
  }
  EXPECT_EQ(texts, (Texts{"2 R,C", "3 1/5/6", "4 ATC,ON", "5 /", "6 VER,1", "7 FMAT,2"}));
}

TEST(Header, ANumberAloneLinksNoTools) {
  EXPECT_EQ(read("M48\n15\n%\n").diagnostics.size(), 1U);
  EXPECT_EQ(read("M48\n1//5\n%\n").diagnostics.size(), 1U);
}

TEST(Header, ToolNumbersAreNeverSplitIntoTwo) {
  const ReadHeader out = read("M48\nINCH,LZ\nT1C.04\nT150C.05\n%\n");
  ASSERT_TRUE(out.header.tools.contains(150));
  EXPECT_DOUBLE_EQ(out.header.tools.at(150).diameter->in_inch(), 0.05);
  EXPECT_DOUBLE_EQ(out.header.tools.at(1).diameter->in_inch(), 0.04);
}

TEST(Header, RefusesContradictions) {
  EXPECT_EQ(read("M48\nINCH,LZ\nMETRIC\n%\n").diagnostics,
            Texts{"p.exc:3:1: error[argument-invalid]"});
  EXPECT_EQ(read("M48\nINCH,LZ\nINCH,TZ\n%\n").diagnostics,
            Texts{"p.exc:3:1: error[argument-invalid]"});
  EXPECT_EQ(read("M48\nT1C.04\nT1C.05\n%\n").diagnostics,
            Texts{"p.exc:3:1: error[argument-invalid]"});
  EXPECT_EQ(read("M48\nT1C.04\nT01C.04\n%\n").diagnostics, Texts{});
}

TEST(Header, RefusesZerosThatNobodyHasWrittenDown) {
  EXPECT_EQ(read("M48\nZA,1\n%\n").diagnostics, Texts{"p.exc:2:1: error[not-supported]"});
  EXPECT_EQ(read("M48\nZS\n%\n").diagnostics, Texts{"p.exc:2:1: error[not-supported]"});
}

TEST(Header, ReadsZerosInThePlacesOfBothAxes) {
  const ReadHeader out = read("M48\nINCH,LZ\nZ,X01Y02\nZC,X.5Y-.5\n%\n");
  EXPECT_EQ(out.diagnostics, Texts{});
  EXPECT_EQ(out.header.zero_set, displacement_mm<frame::Programmed>(25.4, 50.8));
  EXPECT_EQ(out.header.zero_correction, displacement_mm<frame::Programmed>(12.7, -12.7));
  EXPECT_EQ(read("M48\nZC,1,2\n%\n").diagnostics, Texts{"p.exc:2:4: error[argument-invalid]"});
  EXPECT_EQ(read("M48\nZ,X1.\n%\n").diagnostics, Texts{"p.exc:2:3: error[argument-invalid]"});
}

TEST(Header, ReadsTheCommandSetAndTheAxisVersion) {
  EXPECT_EQ(read("M48\n%\n").header.set, ProgramSet::FormatTwo);
  EXPECT_EQ(read("M48\nFMAT,1\n%\n").header.set, ProgramSet::FormatOne);
  EXPECT_EQ(read("M48\nFMAT,3\n%\n").diagnostics, Texts{"p.exc:2:6: error[argument-invalid]"});
  EXPECT_EQ(read("M48\n%\n").header.axis_version, std::nullopt);
  EXPECT_EQ(read("M48\nVER,8\n%\n").header.axis_version, 8);
  EXPECT_EQ(read("M48\nVER,9\n%\n").diagnostics, Texts{"p.exc:2:5: error[argument-invalid]"});
}

TEST(Header, WarnsOnceOfDiametersWithZerosBeyondTheDigits) {
  const ReadHeader out = read("M48\nMETRIC,TZ,000.000\nT1C0000800\nT2C00001000\n%\n");
  EXPECT_EQ(out.diagnostics, Texts{"p.exc:3:3: warning[notation-accepted]"});
  EXPECT_DOUBLE_EQ(out.header.tools.at(1).diameter->in_mm(), 0.8);
  EXPECT_DOUBLE_EQ(out.header.tools.at(2).diameter->in_mm(), 1);
  EXPECT_EQ(read("M48\nMETRIC,TZ\nT1C0000800\n%\n").diagnostics,
            Texts{"p.exc:3:4: error[number-too-long]"});
}

TEST(Header, UnknownWordsNameTheNearestKnownOne) {
  const ReadHeader near = read("M48\n METRICS,LZ\n%\n");
  EXPECT_EQ(near.diagnostics, Texts{"p.exc:2:2: error[header-word-unknown]"});
  EXPECT_THAT(near.texts.at(0), testing::ContainsRegex("METRIC([^S]|$)"));
  EXPECT_EQ(read("M48\nG93\n%\n").diagnostics, Texts{"p.exc:2:1: error[header-word-unknown]"});
}

TEST(Header, TakesTheModesThatCamSystemsWriteIntoIt) {
  EXPECT_TRUE(read("M48\nG91\n%\n").header.incremental);
  EXPECT_FALSE(read("M48\nICI,ON\nG90\n%\n").header.incremental);
  const ReadHeader metric = read("M48\nM71\n%\n");
  EXPECT_EQ(metric.header.format().unit, LengthUnit::Millimeter);
  EXPECT_TRUE(metric.header.stated.states_unit());
  EXPECT_EQ(read("M48\nINCH\nM71\n%\n").diagnostics.size(), 1U);
}

}  // namespace
}  // namespace panelcal::excellon
