// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/nc_param.h"

#include <optional>
#include <string>

#include "program/excellon/text/stated_format.h"
#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

std::string summary(const std::string& text) {
  const auto read = read_nc_param({"nc_param.txt", text});
  if (!read) return read.error().text();
  const StatedFormat stated(ReadOptions{.format_beside = *read});
  return stated.format().summary() + (stated.knows_zeros() ? "" : ", open");
}

/// As the editor writes it, in short.
std::string lines(const std::string& units,
                  const std::string& leading,
                  const std::string& trailing) {
  return "INTEGER-PLACES         2\nDECIMAL-PLACES         5\nX-OFFSET               0.000000\n"
         "COORDINATES            ABSOLUTE\nOUTPUT-UNITS           " +
         units + "\nSUPPRESS-LEAD-ZEROES   " + leading + "\nSUPPRESS-TRAIL-ZEROES  " + trailing +
         "\nHEADER                 none\n";
}

TEST(NcParam, StatesUnitDigitsAndZeros) {
  EXPECT_EQ(summary(lines("METRIC", "NO", "NO")), "metric 2.5, leading zeros kept, open");
  EXPECT_EQ(summary(lines("METRIC", "YES", "NO")), "metric 2.5, trailing zeros kept");
  EXPECT_EQ(summary(lines("ENGLISH", "NO", "YES")), "inch 2.5, leading zeros kept");
}

TEST(NcParam, LeavesZerosOpenThatAreBothLeftOff) {
  EXPECT_EQ(summary(lines("METRIC", "YES", "YES")), "metric 2.5, leading zeros kept, open");
}

TEST(NcParam, HasTheLineThatSaysThatCoordinatesAreSteps) {
  const auto steps = [](const char* text) { return read_nc_param({"nc_param.txt", text})->steps; };
  const auto found = steps("HEADER none\nCOORDINATES            INCREMENTAL\n");
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->text().starts_with("nc_param.txt:2:1: error[not-supported]"));
  EXPECT_FALSE(steps("COORDINATES            ABSOLUTE\n"));
  EXPECT_FALSE(steps("HEADER none\n"));
}

TEST(NcParam, MayStateNothing) {
  EXPECT_EQ(summary(""), "inch 2.4, leading zeros kept, open");
  EXPECT_EQ(summary("HEADER none\n"), "inch 2.4, leading zeros kept, open");
}

/// Half of the digits states none, and would be left out without a word.
TEST(NcParam, RefusesHalfOfTheDigits) {
  EXPECT_TRUE(summary("\nINTEGER-PLACES 2\n").starts_with("nc_param.txt:2:1: "));
  EXPECT_TRUE(summary("DECIMAL-PLACES 5\n").starts_with("nc_param.txt:1:1: "));
}

TEST(NcParam, NamesTheLineThatCannotBeRead) {
  EXPECT_TRUE(summary("OUTPUT-UNITS FURLONGS\n").starts_with("nc_param.txt:1:1: "));
  EXPECT_TRUE(summary("HEADER none\nINTEGER-PLACES 0\n").starts_with("nc_param.txt:2:1: "));
  EXPECT_TRUE(summary("INTEGER-PLACES 2\nINTEGER-PLACES 3\n").starts_with("nc_param.txt:2:1: "));
  EXPECT_TRUE(summary("SUPPRESS-LEAD-ZEROES\n").starts_with("nc_param.txt:1:1: "));
  EXPECT_TRUE(summary("COORDINATES RELATIVE\n").starts_with("nc_param.txt:1:1: "));
  EXPECT_TRUE(summary("\nSUPPRESS-LEADING-ZEROS YES\n").starts_with("nc_param.txt:2:1: "));
  EXPECT_EQ(summary("SUPPRESS-EQUAL YES\n"), "inch 2.4, leading zeros kept, open");
}

}  // namespace
}  // namespace panelcal::excellon
