// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/cnc_commands.h"

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

/// `SA|X3.Y100.`: name and argument.
std::string found(std::string_view text) {
  const auto command = find_cnc_command(text);
  if (!command) return "nothing";
  return std::string(command->info->name) + "|" + std::string(command->argument);
}

/// `X3 Y100`, without the letter that is not there.
std::string xy_of(std::string_view argument) {
  const auto xy = read_xy(argument);
  if (!xy) return "nothing";
  std::string out;
  for (const std::size_t axis : {0, 1}) {
    if (!(*xy).at(axis)) continue;
    if (!out.empty()) out += ' ';
    out += (axis == 0 ? "X" : "Y") + std::to_string(*(*xy).at(axis));
  }
  return out;
}

/// Every M49 of the manual.
TEST(CncCommands, ManualExamples) {
  EXPECT_EQ(found("SAX3.Y100."), "SA|X3.Y100.");
  EXPECT_EQ(found("SAZX200.Y400."), "SAZ|X200.Y400.");
  EXPECT_EQ(found("NOFA"), "NOFA|");
  EXPECT_EQ(found("NORA"), "NORA|");
  EXPECT_EQ(found("NOSA"), "NOSA|");
  EXPECT_EQ(found("FAX123.432Y256.753"), "FA|X123.432Y256.753");
  EXPECT_EQ(found("FV1"), "FV|1");
  EXPECT_EQ(found("CHEKX100.Y10.DXDY10."), "CHEK|X100.Y10.DXDY10.");
  EXPECT_EQ(found("MAPT1.0"), "MAPT|1.0");
}

/// Forms that the text names besides, with its argument behind a comma.
TEST(CncCommands, ACommaIsNoPartOfTheArgument) {
  EXPECT_EQ(found("SPAV,A"), "SPAV|A");
  EXPECT_EQ(found("PRGM,-I"), "PRGM|-I");
  EXPECT_EQ(found("ROUT,-A"), "ROUT|-A");
  EXPECT_EQ(found("BOTT,R"), "BOTT|R");
  EXPECT_EQ(found("CAMM,J"), "CAMM|J");
  EXPECT_EQ(found("PEKM,M4"), "PEKM|M4");
  EXPECT_EQ(found("TPEK,I1J2"), "TPEK|I1J2");
  EXPECT_EQ(found("SPAV,,A"), "SPAV|,A");
}

TEST(CncCommands, TheLongestNameWins) {
  EXPECT_EQ(found("SAZ"), "SAZ|");
  EXPECT_EQ(found("NIBO"), "NIBO|");
  EXPECT_EQ(found("NIB.3"), "NIB|.3");
  EXPECT_EQ(found("CCWI"), "CCWI|");
  EXPECT_EQ(found("CCW"), "CCW|");
}

TEST(CncCommands, ANameEndsBeforeXOrYAndAtWhateverIsNoLetter) {
  EXPECT_EQ(found("FAX"), "FA|X");
  EXPECT_EQ(found("FAY1."), "FA|Y1.");
  EXPECT_EQ(found("RA-90"), "RA|-90");
  EXPECT_EQ(found("RA.5"), "RA|.5");
  EXPECT_EQ(found("SA 3"), "SA| 3");
}

TEST(CncCommands, OtherNamesAreNone) {
  for (const char* const text :
       {"", ",", "S", "SAB", "FAR", "FAA", "NOS", "XSA", "sax3.", "M101", "FOO", " SA", "SPAVA"}) {
    EXPECT_EQ(found(text), "nothing") << text;
  }
}

TEST(CncCommands, EveryRowIsFoundByItsName) {
  std::set<std::string_view> names;
  for (const CncInfo& row : cnc_table()) {
    const auto command = find_cnc_command(row.name);
    ASSERT_TRUE(command) << row.name;
    EXPECT_EQ(command->info, &row) << row.name;
    EXPECT_EQ(command->argument, "");
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(row.effect.empty()) << row.name;
  }
}

/// `info` of a code is the row in the order of the table.
TEST(CncCommands, RowsStandInTheOrderOfTheirCodes) {
  for (const CncInfo& row : cnc_table()) {
    EXPECT_EQ(&row, &cnc_table()[static_cast<std::size_t>(row.code)]) << row.name;
  }
}

TEST(CncCommands, TreatmentsHaveNames) {
  EXPECT_EQ(name(Treatment::Obeyed), "obeyed");
  EXPECT_EQ(name(Treatment::Passed), "passed on");
  EXPECT_EQ(name(Treatment::Refused), "refused");
}

// --- arguments -----------------------------------------------------------------------------------

TEST(CncArgument, NumbersStandBehindXAndY) {
  EXPECT_EQ(xy_of("X3.Y100."), xy_of("X3Y100"));
  EXPECT_EQ(xy_of("X3.Y100."), "X3.000000 Y100.000000");
  EXPECT_EQ(xy_of("Y-.5X+1.25"), "X1.250000 Y-0.500000");
  EXPECT_EQ(xy_of("X1.Y2."), "X1.000000 Y2.000000");
}

TEST(CncArgument, ALetterWithoutANumberIsZero) {
  EXPECT_EQ(xy_of("XY"), "X0.000000 Y0.000000");
  EXPECT_EQ(xy_of("X1.Y"), "X1.000000 Y0.000000");
}

TEST(CncArgument, WhatIsNotSaidIsAbsent) {
  EXPECT_EQ(xy_of(""), "");
  EXPECT_EQ(xy_of("Y1."), "Y1.000000");
}

TEST(CncArgument, TheLastOfTwoHolds) {
  EXPECT_EQ(xy_of("X1.X2."), "X2.000000");
}

TEST(CncArgument, AnythingElseIsRefused) {
  for (const char* const argument : {"1.",
                                     "A",
                                     "X1.Z2.",
                                     "X1.Y10.DXDY10.",
                                     "X1. Y2.",
                                     " X1.",
                                     "X1,Y2",
                                     "X-",
                                     "X.",
                                     "X1.2.3",
                                     "X--1",
                                     "X+-1",
                                     "X++1",
                                     "X1e3",
                                     "Xinf",
                                     "x1."}) {
    EXPECT_EQ(xy_of(argument), "nothing") << argument;
  }
}

TEST(PlainNumber, IsReadWithOrWithoutAPoint) {
  EXPECT_EQ(read_plain_number("3"), 3);
  EXPECT_EQ(read_plain_number("3."), 3);
  EXPECT_EQ(read_plain_number(".25"), 0.25);
  EXPECT_EQ(read_plain_number("-1.5"), -1.5);
  EXPECT_EQ(read_plain_number("+1.5"), 1.5);
  EXPECT_EQ(read_plain_number("0"), 0);
}

TEST(PlainNumber, IsNothingElse) {
  for (const char* const text :
       {"", "+", "-", ".", "+-1", "1-", "1.2.", "1e5", "nan", "inf", "0x1", " 1", "1 "}) {
    EXPECT_EQ(read_plain_number(text), std::nullopt) << text;
  }
  EXPECT_EQ(read_plain_number(std::string(400, '9')), std::nullopt);
}

// --- in another unit -----------------------------------------------------------------------------

std::string in_mm(std::string_view text, int n_decimals = 3) {
  return command_in_mm(text, inch(1), n_decimals).value_or("nothing");
}

TEST(CommandInMm, ConvertsTheLengthOfACommand) {
  EXPECT_EQ(in_mm("MAPT.04"), "MAPT1.016");
  EXPECT_EQ(in_mm("BOTR.002"), "BOTR0.051");
  EXPECT_EQ(in_mm("BOTR0.06"), "BOTR1.524");
  EXPECT_EQ(in_mm("TOPR-1."), "TOPR-25.4");
  EXPECT_EQ(in_mm("BOTK,.1"), "BOTK,2.54");
  EXPECT_EQ(in_mm("NIB.0005"), "NIB0.013");
  EXPECT_EQ(in_mm("NIB.0005", 6), "NIB0.0127");
  EXPECT_EQ(in_mm("TOPK10."), "TOPK254.");
  EXPECT_EQ(in_mm("BOTR0"), "BOTR0.");
}

/// 0.002 inch is 0.0508 mm: 0.051 would allow more.
TEST(CommandInMm, RoundsTolerancesDown) {
  EXPECT_EQ(in_mm("BOTT,R.002"), "BOTT,R0.05");
  EXPECT_EQ(in_mm("TOPT.0005"), "TOPT0.012");
  EXPECT_EQ(in_mm("MAPT.0005", 6), "MAPT0.0127");
  EXPECT_EQ(in_mm("MAPT.00003"), "nothing");
  // A whole number of steps stays one, whatever its double is.
  for (int n = 1; n <= 1000; ++n) {
    const std::string inch = fmt::format("{}.{:03}", n / 200, n % 200 * 5);
    const auto mm = in_mm("MAPT" + inch);
    EXPECT_EQ(mm.substr(4), [&] {
      std::string exact = fmt::format("{}.{:03}", n * 127 / 1000, n * 127 % 1000);
      exact.erase(exact.find_last_not_of('0') + 1);
      return exact;
    }()) << inch;
  }
}

TEST(CommandInMm, HasAStatedPlaceForEachLengthThatIsObeyed) {
  int n_lengths = 0;
  for (const CncInfo& row : cnc_table()) {
    if (row.treatment != Treatment::Obeyed || !row.effect.ends_with("in the unit of the program"))
      continue;
    ++n_lengths;
    const std::string name(row.name);
    EXPECT_EQ(in_mm(name + "1."), name + "25.4");
    EXPECT_EQ(in_mm(name + "1"), "nothing");
    EXPECT_TRUE(states_lengths(*find_cnc_command(name + "1."))) << name;
  }
  EXPECT_EQ(n_lengths, 8);
  EXPECT_TRUE(states_lengths(*find_cnc_command("FAX1.Y1.")));
  EXPECT_TRUE(states_lengths(*find_cnc_command("SAZX1.Y1.")));
  for (const char* const text : {"SAX1.Y1.", "RA30", "FV1", "BOTL5", "QUIK5", "SPAV,A"}) {
    EXPECT_FALSE(states_lengths(*find_cnc_command(text))) << text;
  }
}

TEST(CommandInMm, LeavesWhatHasNoLength) {
  for (const char* const text : {"SPAV,A",
                                 "BOTL5",
                                 "PEKM,M4",
                                 "OPID,BOARD 7",
                                 "BROK2",
                                 "CATM5",
                                 "CHEKT1T2",
                                 "CHEK,E",
                                 "DEPM,Z",
                                 "FORB,A",
                                 "OD1",
                                 "ROV0",
                                 "CAMN7",
                                 "UNKNOWN"}) {
    EXPECT_EQ(in_mm(text), text);
  }
}

TEST(CommandInMm, GivesNothingForNumbersThatNothingDescribes) {
  for (const char* const text : {"CHEK,S1XYDX2.DY0.N20",
                                 "CHEKX100.Y10.DXDY10.",
                                 "APEK,D1I2J3",
                                 "DPEK,D1I2J3",
                                 "TPEK,I1J2",
                                 "QUIK5",
                                 "DEPM3",
                                 "FORB,X1.Y2.D.5",
                                 "SPEK1",
                                 "UNKNOWN1",
                                 "MAPT.00001"}) {
    EXPECT_EQ(in_mm(text), "nothing") << text;
  }
}

}  // namespace
}  // namespace panelcal::sieb_meyer
