// SPDX-License-Identifier: Apache-2.0
// The exact words, line and column of what a person is told about routing, cycles and patterns.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::metric;
using test::run_program;

using Texts = std::vector<std::string>;

/// A body and the only diagnostic it gives. T2 has no diameter. Body lines count from 7.
struct Case {
  std::string body;
  std::string text;
};

Texts diagnostics_of(const std::string& body) {
  ReadOptions reading;
  reading.pattern_folders = {"patterns", "more"};
  return run_program("M48\nMETRIC,LZ\nT1C1.0\nT2F100\n%\nT1\n" + body, {}, reading).diagnostics;
}

void expect_each(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    EXPECT_EQ(diagnostics_of(one.body + "M30\n"), Texts{"p.exc:" + one.text}) << one.body;
  }
}

/// `block` while the router is down, in line 9.
Case plunged(const std::string& block, const std::string& text) {
  return {"G00X1.Y1.\nM15\n" + block + "\nM17\n", text};
}

TEST(MotionDiagnostics, RoutModeBegins) {
  const std::string expected = ", expected rout mode: G00X#Y# before it";
  expect_each({
      {"G01X2.\n", "7:1: error[command-misplaced]: \"G01\" in \"G01X2.\"" + expected},
      {"G02X2.A1.\n", "7:1: error[command-misplaced]: \"G02\" in \"G02X2.A1.\"" + expected},
      {"M15\n", "7:1: error[command-misplaced]: \"M15\" in \"M15\", expected G00X#Y# before it"},
      {"G00\nM14\n",
       "8:1: error[command-misplaced]: \"M14\" in \"M14\", expected G00X#Y# before it"},
      {"G00X1.Y1.\nG01X2.\n",
       "8:1: error[rout-not-plunged]: \"G01\" in \"G01X2.\", expected G00X#Y#, then M15 or M14"},
  });
}

TEST(MotionDiagnostics, WhileTheRouterIsDown) {
  const std::string expected = ", expected M16 or M17 before it";
  expect_each({
      plunged("G00X2.", "9:1: error[tool-plunged]: \"G00\" in \"G00X2.\"" + expected),
      plunged("G41", "9:1: error[tool-plunged]: \"G41\" in \"G41\"" + expected),
      plunged("T2", "9:1: error[tool-plunged]: \"T2\" in \"T2\"" + expected),
      plunged("M15", "9:1: error[tool-plunged]: \"M15\" in \"M15\"" + expected),
      {"M25\nG00X1.Y1.\nM15\nM01\nM08\n",
       "10:1: error[tool-plunged]: the pattern ends while the router is down, expected M16 or M17 "
       "at its end"},
  });
}

TEST(MotionDiagnostics, Arcs) {
  expect_each({
      plunged("G02X5.",
              "9:1: error[arc-invalid]: \"G02\" in \"G02X5.\", expected A#, or I#J#, in this block "
              "or before it"),
      plunged("G02X1.Y1.A5.",
              "9:1: error[arc-invalid]: \"G02\" in \"G02X1.Y1.A5.\", expected an end away from the "
              "start; a full circle takes two arcs"),
      plunged("G03X5.I1.J1.",
              "9:1: error[arc-invalid]: \"G03\" in \"G03X5.I1.J1.\", expected a centre equally far "
              "from both ends, for an arc of at most 180 degrees"),
      plunged(
          "G02X5.A1.",
          "9:1: warning[arc-adjusted]: \"G02X5.A1.\": the radius is changed by 1.0000 mm to fit "
          "both ends"),
  });
}

TEST(MotionDiagnostics, WhatCyclesNeed) {
  expect_each({
      {"G32X1.\n",
       "7:1: error[arc-invalid]: \"G32\" in \"G32X1.\", expected A#, in this block or before it"},
      {"G32A5.\n",
       "7:1: error[coordinate-missing]: \"G32\" in \"G32A5.\", expected X and Y of the centre"},
      {"T2\nG33X1.A5.\n",
       "8:1: error[diameter-missing]: \"G33\" in \"G33X1.A5.\", expected CP,#,# in the header, or "
       "C# of the tool"},
      {"T2\nX1.Y1.G85X5.\n",
       "8:7: error[diameter-missing]: \"G85\" in \"X1.Y1.G85X5.\", expected C# of the tool"},
      {"G82\nX1.Y1.\nT2\n",
       "9:1: error[cycle-unfinished]: \"T2\" comes before the coordinates of \"G82\" in line 7, "
       "expected X#Y# of both corners, a block each"},
      {"M98,AB\nG05\n",
       "8:1: error[cycle-unfinished]: \"G05\" comes before the coordinates of \"M98,AB\" in line "
       "7, "
       "expected X#Y#"},
      {"M97,no\nX1.Y1.\n",
       "7:1: error[argument-invalid]: \"n\" in \"M97,no\", expected A to Z, 0 to 9, + - / * and "
       "commas for spaces"},
  });
}

TEST(MotionDiagnostics, RepeatedPatterns) {
  expect_each({
      {"P2X1.\n",
       "7:1: error[repeat-without-pattern]: \"P2\" in \"P2X1.\", expected G81 to G85, or M99, "
       "before "
       "it"},
      {"P1000X1.\n",
       "7:1: error[argument-invalid]: \"P1000\" in \"P1000X1.\", expected P1 to P999"},
      {"P2\n", "7:1: error[coordinate-missing]: \"P2\" in \"P2\", expected P#X#Y#"},
  });
}

TEST(MotionDiagnostics, StoredPatterns) {
  expect_each({
      {"M99,../X\nX1.Y1.\n",
       "7:1: error[argument-invalid]: \"M99\" in \"M99,../X\", expected M99,name of a file"},
  });
  EXPECT_EQ(
      diagnostics_of("M99,GONE\nX1.Y1.\nM30\n"),
      Texts{"p.exc:7:1: error[pattern-missing]: there is no stored pattern \"GONE\", expected "
            "a file in \"patterns\", \"more\""});
}

TEST(MotionDiagnostics, Messages) {
  expect_each({
      {"M47,ABCDEFGHIJKLMNOPQRSTU\n",
       "7:25: warning[message-too-long]: \"ABCDEFGHIJKLMNOPQRSTU\", expected at most 20 "
       "characters, "
       "or M45"},
      {"M60\n",
       "7:1: warning[scaling-unknown]: \"M60\" is passed on to the machine, expected "
       "[reference_scaling] in machine.toml"},
      {"M96\n", "7:1: error[argument-invalid]: \"M96\" in \"M96\", expected M96,# or M96,OFF"},
  });
}

}  // namespace
}  // namespace panelcal
