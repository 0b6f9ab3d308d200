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
  expect_each({
      {"G01X2.\n", "7:1: error[command-misplaced]"},
      {"G02X2.A1.\n", "7:1: error[command-misplaced]"},
      {"M15\n", "7:1: error[command-misplaced]"},
      {"G00\nM14\n", "8:1: error[command-misplaced]"},
      {"G00X1.Y1.\nG01X2.\n", "8:1: error[rout-not-plunged]"},
  });
}

TEST(MotionDiagnostics, WhileTheRouterIsDown) {
  expect_each({
      plunged("G00X2.", "9:1: error[tool-plunged]"),
      plunged("G41", "9:1: error[tool-plunged]"),
      plunged("T2", "9:1: error[tool-plunged]"),
      plunged("M15", "9:1: error[tool-plunged]"),
      {"M25\nG00X1.Y1.\nM15\nM01\nM08\n", "10:1: error[tool-plunged]"},
  });
}

/// "The Compensation Index value must be entered before the rout mode is turned on (G00 command)."
TEST(MotionDiagnostics, TheCompensationIndexComesBeforeG00) {
  const std::string contour = "G41\nM15\nG01X2.\nM17\n";
  EXPECT_EQ(diagnostics_of("G00X1.Y1.\nT0102\n" + contour + "M30\n"),
            Texts{"p.exc:8:1: warning[compensation-late]"});
  for (const char* in_time :
       {"T0102\nG00X1.Y1.\n", "G00X1.Y1.\nT0102\nG00X1.Y1.\n", "T0102\nG00X1.Y1.\nT0102\n"}) {
    EXPECT_EQ(diagnostics_of(in_time + contour + "M30\n"), Texts{}) << in_time;
  }
  EXPECT_EQ(diagnostics_of("G00X1.Y1.\nT0102\nM15\nG01X2.\nM17\nM30\n"), Texts{});
}

/// "The Y value determines the space between the two rows."
TEST(MotionDiagnostics, TheRowsOfAPackageAreAsFarApartAsItsBlockSays) {
  expect_each({
      {"G82X1.Y1.\nX1.Y1.\nX4.Y3.\n", "7:1: warning[rows-contradicted]"},
      {"G81X1.\nX1.Y1.\nX31.Y21.\n", "7:1: warning[rows-contradicted]"},
  });
  EXPECT_EQ(diagnostics_of("G82X1.Y2.\nX1.Y1.\nX4.Y3.\nM30\n"), Texts{});
  EXPECT_EQ(diagnostics_of("G82X1.Y3.\nX1.Y1.\nX4.Y3.\nM30\n"), Texts{});
}

TEST(MotionDiagnostics, Arcs) {
  expect_each({
      plunged("G02X5.", "9:1: error[arc-invalid]"),
      plunged("G02X1.Y1.A5.", "9:1: error[arc-invalid]"),
      plunged("G03X5.I1.J1.", "9:1: error[arc-invalid]"),
      plunged("G02X5.A1.", "9:1: warning[arc-adjusted]"),
  });
}

TEST(MotionDiagnostics, WhatCyclesNeed) {
  expect_each({
      {"G32X1.\n", "7:1: error[arc-invalid]"},
      {"G32A5.\n", "7:1: error[coordinate-missing]"},
      {"T2\nG33X1.A5.\n", "8:1: error[diameter-missing]"},
      {"T2\nX1.Y1.G85X5.\n", "8:7: error[diameter-missing]"},
      {"G82\nX1.Y1.\nT2\n", "9:1: error[cycle-unfinished]"},
      {"M98,AB\nG05\n", "8:1: error[cycle-unfinished]"},
      {"M97,no\nX1.Y1.\n", "7:1: error[argument-invalid]"},
  });
}

TEST(MotionDiagnostics, RepeatedPatterns) {
  expect_each({
      {"P2X1.\n", "7:1: error[repeat-without-pattern]"},
      {"P1000X1.\n", "7:1: error[argument-invalid]"},
      {"P2\n", "7:1: error[coordinate-missing]"},
  });
}

TEST(MotionDiagnostics, StoredPatterns) {
  expect_each({
      {"M99,../X\nX1.Y1.\n", "7:1: error[argument-invalid]"},
  });
  EXPECT_EQ(diagnostics_of("M99,GONE\nX1.Y1.\nM30\n"), Texts{"p.exc:7:1: error[pattern-missing]"});
}

TEST(MotionDiagnostics, Messages) {
  expect_each({
      {"M47,ABCDEFGHIJKLMNOPQRSTU\n", "7:25: warning[message-too-long]"},
      {"M60\n", "7:1: warning[scaling-unknown]"},
      {"M96\n", "7:1: error[argument-invalid]"},
  });
}

}  // namespace
}  // namespace panelcal
