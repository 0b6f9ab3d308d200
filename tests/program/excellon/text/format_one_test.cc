// SPDX-License-Identifier: Apache-2.0
// FMAT,1: CNC-7 manual, List of Equivalent Format One Commands, row by row.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::ProgramRun;
using test::run_program;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

using Lines = std::vector<std::string>;

/// `body` from line 6 on.
std::string format_one(const std::string& body) {
  return "M48\nINCH,LZ\nFMAT,1\nT1C.04\n%\n" + body;
}
std::string format_two(const std::string& body) {
  return "M48\nINCH,LZ\nFMAT,2\nT1C.04\n%\n" + body;
}

/// Operations with lines but without settings, which are passed on as written.
Lines executed(std::string text) {
  const ProgramRun run = run_program(std::move(text));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  Lines out;
  for (const std::string& line : run.executed.lines()) {
    if (line.find(" setting ") == std::string::npos) out.push_back(line);
  }
  return out;
}

/// Both do the same, and `expected` is part of it.
void expect_equivalent(const std::string& two, const std::string& one, const Lines& expected) {
  const Lines done = executed(format_one(one));
  EXPECT_EQ(done, executed(format_two(two))) << one;
  for (const std::string& line : expected) EXPECT_THAT(done, Contains(line)) << one;
}

TEST(FormatOne, G81IsG05) {
  expect_equivalent("T1\nG05\nX01Y01\nX02Y02\nM30\n",
                    "T1\nG81\nX01Y01\nX02Y02\nM30\n",
                    {"8 drill 1 (25.4, 25.4)", "9 drill 1 (50.8, 50.8)"});
}

TEST(FormatOne, M02IsM00) {
  expect_equivalent("T1\nX01Y01\nM00X01Y02\n", "T1\nX01Y01\nM02X01Y02\n", {"8 end (25.4, 50.8)"});
  expect_equivalent("T1\nX01Y01\nM00\n", "T1\nX01Y01\nM02\n", {"8 end"});
}

TEST(FormatOne, M24M26M27AreM01M02M08) {
  expect_equivalent("T1\nM25\nX01Y01\nM01\nM02X02\nM02X02Y01\nM02\nM08\nM30\n",
                    "T1\nM25\nX01Y01\nM24\nM26X02\nM26X02Y01\nM26\nM27\nM30\n",
                    {"8 drill 1 (25.4, 25.4) [0]",
                     "8 drill 1 (76.2, 25.4) [1]",
                     "8 drill 1 (127, 50.8) [2]",
                     "14 end rewind"});
  expect_equivalent("T1\n%\nX01Y01\nM01\nR1M02X02\nM01\nM02Y02\nM08M30\n",
                    "T1\n%\nX01Y01\nM24\nR1M26X02\nM24\nM26Y02\nM27M30\n",
                    {"8 drill 1 (76.2, 76.2) [1,1]"});
}

TEST(FormatOne, M01IsM06) {
  expect_equivalent("T1\nM06X01Y02\nM06\nX01Y01\nM30\n",
                    "T1\nM01X01Y02\nM01\nX01Y01\nM30\n",
                    {"7 optional (25.4, 50.8)", "8 optional", "10 end rewind"});
}

TEST(FormatOne, M00IsM09) {
  expect_equivalent("T1\nM09X01Y02\nM09\nX01Y01\nM30\n",
                    "T1\nM00X01Y02\nM00\nX01Y01\nM30\n",
                    {"7 inspection (25.4, 50.8)", "8 inspection", "10 end rewind"});
}

TEST(FormatOne, M23IsM70) {
  expect_equivalent("T1\nM25\nX01Y02\nM01\nM02X10Y20M70\nM08\nM30\n",
                    "T1\nM25\nX01Y02\nM24\nM26X10Y20M23\nM27\nM30\n",
                    {"8 drill 1 (304.8, 533.4) [1]"});  // (2, 1) and (10, 20) inch
}

TEST(FormatOne, M21IsM80) {
  expect_equivalent("T1\nM25\nX01Y02\nM01\nM02X10Y20M80\nM08\nM30\n",
                    "T1\nM25\nX01Y02\nM24\nM26X10Y20M21\nM27\nM30\n",
                    {"8 drill 1 (228.6, 558.8) [1]"});  // (-1, 2) and (10, 20) inch
}

TEST(FormatOne, M22IsM90) {
  expect_equivalent("T1\nM25\nX01Y02\nM01\nM02X10Y20M90\nM08\nM30\n",
                    "T1\nM25\nX01Y02\nM24\nM26X10Y20M22\nM27\nM30\n",
                    {"8 drill 1 (279.4, 457.2) [1]"});  // (1, -2) and (10, 20) inch
}

TEST(FormatOne, MirrorsAndSwapCombine) {
  expect_equivalent("T1\nM25\nX01Y02\nM01\nM02X10Y20M80M90M70\nM08\nM30\n",
                    "T1\nM25\nX01Y02\nM24\nM26X10Y20M21M22M23\nM27\nM30\n",
                    {"8 drill 1 (203.2, 482.6) [1]"});  // (-2, -1) and (10, 20) inch
}

TEST(FormatOne, RepeatBlockIsWithM26) {
  expect_equivalent("T1\nM25\nX01Y01\nM01\nR3M02Y02\nM08\nM30\n",
                    "T1\nM25\nX01Y01\nM24\nR3M26Y02\nM27\nM30\n",
                    {"8 drill 1 (25.4, 177.8) [3]"});
}

TEST(FormatOne, M70IsM72) {
  const std::string rest = "\nT1\nX01Y02\nM30\n";
  const std::string header = "M48\nMETRIC,LZ\nT1C1.\n";
  const Lines one = executed(header + "FMAT,1\n%\nM70" + rest);
  EXPECT_EQ(one, executed(header + "FMAT,2\n%\nM72" + rest));
  EXPECT_THAT(one, Contains("8 drill 1 (25.4, 50.8)"));
}

TEST(FormatOne, WhatTheTableDoesNotListIsTheSame) {
  expect_equivalent("T1\nG90\nM47,HELLO\nG93X01Y01\nX01Y01\nR2X01\nM30X01Y01\n",
                    "T1\nG90\nM47,HELLO\nG93X01Y01\nX01Y01\nR2X01\nM30X01Y01\n",
                    {"8 message HELLO", "10 drill 1 (50.8, 50.8)", "12 end rewind (25.4, 25.4)"});
  expect_equivalent("T1\nG82\nX01Y01\nX015Y013\nM30\n", "T1\nG82\nX01Y01\nX015Y013\nM30\n", {});
}

auto refused(int line) {
  return AllOf(StartsWith("p.exc:" + std::to_string(line) + ":"), HasSubstr(" error["));
}

TEST(FormatOne, RefusesTheFormatTwoCodesThatHaveAnEquivalent) {
  for (const char* block : {"G05", "M06", "M09", "M72"}) {
    EXPECT_THAT(run_program(format_one(block + std::string("\nT1\nM30\n"))).diagnostics,
                Contains(refused(6)))
        << block;
  }
  for (const char* block : {"M08", "M26X02M70", "M26X02M80", "M26X02M90", "R2M02X02"}) {
    EXPECT_THAT(
        run_program(format_one("T1\nM25\nX01Y01\nM24\n" + std::string(block) + "\nM27\nM30\n"))
            .diagnostics,
        Contains(refused(10)))
        << block;
  }
}

TEST(FormatOne, ItsOwnCodesAreRefusedInFormatTwo) {
  for (const char* block : {"M26X02", "M27", "M24", "M02X02M21", "M02X02M22", "M02X02M23"}) {
    EXPECT_THAT(
        run_program(format_two("T1\nM25\nX01Y01\nM01\n" + std::string(block) + "\nM08\nM30\n"))
            .diagnostics,
        Contains(refused(10)))
        << block;
  }
}

}  // namespace
}  // namespace panelcal
