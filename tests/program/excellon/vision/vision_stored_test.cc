// SPDX-License-Identifier: Apache-2.0
// Stored corrections: CNC-7 manual, Vision Step and Repeat (M50, M51, M52).
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::run_program;

using Texts = std::vector<std::string>;

constexpr double kRounding_mm = 1e-10;

/// The targets' x shifts, one per measurement, in order.
FunctionSource shifted_in_turn(std::vector<double> shifts_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() +
           Vector2d(shifts_mm.at(static_cast<std::size_t>(request.seq)), 0);
  });
}

/// The x shifts of the holes. Body lines count from 8; series of one G36 or G46.
std::vector<double> hole_shifts(std::string_view body,
                                std::vector<double> shifts_mm,
                                int series_size = 1) {
  FunctionSource source = shifted_in_turn(std::move(shifts_mm));
  WalkOptions options;
  options.series_size = series_size;
  const ProgramRun run =
      run_program(metric("G34,1\nT1\n" + std::string(body) + "M30\n"), options, source);
  EXPECT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  std::vector<double> out;
  for (const test::Hole& hole : run.holes()) {
    out.push_back(hole.actual_mm().x() - hole.nominal_mm().x());
  }
  return out;
}

void expect_shifts(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], kRounding_mm) << "hole " << i;
  }
}

constexpr char kThreeBoards[] = "M01\nR2M02X10.\nM08\n";

std::string measure_three_boards(const std::string& targets) {
  return "M50,1\nM25\n" + targets + kThreeBoards;
}

TEST(StoredCorrections, EachInstanceTakesItsOwn) {
  expect_shifts(
      hole_shifts(measure_three_boards("G46X0.Y0.\n") + "M51,1\nM25\nM52\nX1.Y1.\n" + kThreeBoards,
                  {.1, .2, .3}),
      {.1, .2, .3});
}

TEST(StoredCorrections, CanBeUsedAgainAfterARewind) {
  const std::string use = std::string("M51,1\nM25\nM52\nX1.Y1.\n") + kThreeBoards;
  expect_shifts(hole_shifts(measure_three_boards("G46X0.Y0.\n") + use + "T2\n" + use, {.1, .2, .3}),
                {.1, .2, .3, .1, .2, .3});
}

/// "Normally used in the part program right before an M25": a program may place its boards itself.
TEST(StoredCorrections, AreReplayedWithoutM25) {
  expect_shifts(hole_shifts(measure_three_boards("G46X0.Y0.\n") +
                                "M51,1\nM52\nX1.Y1.\nM52\nX11.Y1.\nM52,1\nX21.Y1.\n",
                            {.1, .2, .3}),
                {.1, .2, .3});
}

TEST(StoredCorrections, AReplayWithoutM25EndsWithItsLastBoard) {
  const std::string replay =
      measure_three_boards("G46X0.Y0.\n") + "M51,1\nM52\nX1.Y1.\nM52\nX11.Y1.\nM52\nX21.Y1.\nG47\n";
  expect_shifts(hole_shifts(replay + "M25\nX2.Y2.\n" + kThreeBoards, {.1, .2, .3}),
                {.1, .2, .3, 0, 0, 0});
}

TEST(StoredCorrections, AReplayWithoutM25GoesOnBehindACancellation) {
  expect_shifts(
      hole_shifts(measure_three_boards("G46X0.Y0.\n") +
                      "M51,1\nM52\nX1.Y1.\nG47\nX2.Y2.\nM52\nX11.Y1.\nG47\nM52\nX21.Y1.\n",
                  {.1, .2, .3}),
      {.1, 0, .2, .3});
}

TEST(StoredCorrections, ThreeM52AreOneM52WithThree) {
  const std::string targets = "G46X0.Y0.\nG46X9.Y0.\nG46X0.Y9.\n";
  const std::vector<double> seen = {.1, .1, .1, .2, .2, .2, .3, .3, .3};
  for (const char* advance : {"M52,3\n", "M52\nM52\nM52\n", "M52,2\nM52\n", "M52,1\nM52,2\n"}) {
    expect_shifts(hole_shifts(measure_three_boards(targets) + "M51,1\nM25\n" + advance +
                                  "X1.Y1.\n" + kThreeBoards,
                              seen,
                              3),
                  {.1, .2, .3});
  }
}

TEST(StoredCorrections, SinglePointOffsetsAreSeriesOfOne) {
  expect_shifts(
      hole_shifts(measure_three_boards("G45X0.Y0.\n") + "M51,1\nM25\nM52\nX1.Y1.\n" + kThreeBoards,
                  {.1, .2, .3},
                  3),
      {.1, .2, .3});
}

TEST(StoredCorrections, HolesAtTargetsAreNotStored) {
  expect_shifts(hole_shifts(measure_three_boards("G48X0.Y0.\nG46X0.Y0.\n") +
                                "M51,1\nM25\nM52\nX1.Y1.\n" + kThreeBoards,
                            {7, .1, 7, .2, 7, .3}),
                {7, 7, 7, .1, .2, .3});
}

TEST(StoredCorrections, BaseCorrectionsAreStoredLikewise) {
  expect_shifts(
      hole_shifts(measure_three_boards("G36X0.Y0.\n") + "M51,1\nM25\nM52\nX1.Y1.\n" + kThreeBoards,
                  {.1, .2, .3}),
      {.1, .2, .3});
}

TEST(StoredCorrections, BaseAndNestedOfOneInstanceComeBackTogether) {
  expect_shifts(hole_shifts(measure_three_boards("G36X0.Y0.\nG46X0.Y0.\n") +
                                "M51,1\nM25\nM52\nX1.Y1.\nM52\nX1.Y1.\n" + kThreeBoards,
                            {.1, .15, .2, .25, .3, .35}),
                {.1, .15, .2, .25, .3, .35});
}

TEST(StoredCorrections, LabelsAreKeptApart) {
  expect_shifts(hole_shifts("M50,1\nM25\nG46X0.Y0.\nM01\nM08\nM50,2\nM25\nG46X0.Y0.\nM01\nM08\n"
                            "M51,1\nM52\nX1.Y1.\nM51,2\nM52\nX1.Y1.\nM51,1\nM52\nX1.Y1.\n",
                            {.1, .2}),
                {.1, .2, .1});
}

TEST(StoredCorrections, RecordingEndsAtM08) {
  expect_shifts(hole_shifts("M50,1\nM25\nG46X0.Y0.\nM01\nM08\nG46X0.Y0.\nX1.Y1.\nM51,1\nM52\n"
                            "X1.Y1.\n",
                            {.1, .9}),
                {.9, .1});
}

TEST(StoredCorrections, ALabelStoredAgainIsReplaced) {
  const std::string record = "M50,1\nM25\nG46X0.Y0.\nM01\nM08\n";
  expect_shifts(hole_shifts(record + record + "M51,1\nM52\nX1.Y1.\n", {.1, .2}), {.2});
}

TEST(StoredCorrections, WhatIsMeasuredWhileStoringIsInForceAtOnce) {
  expect_shifts(
      hole_shifts("M50,1\nM25\nG46X0.Y0.\nX1.Y1.\n" + std::string(kThreeBoards), {.1, .2, .3}),
      {.1, .2, .3});
}

// --- refusals ------------------------------------------------------------------------------------

Texts diagnostics_of(std::string_view body, int series_size = 1) {
  WalkOptions options;
  options.series_size = series_size;
  return run_program(metric("G34,1\nT1\n" + std::string(body) + "M30\n"), options).diagnostics;
}

constexpr char kStoreThree[] = "M50,1\nM25\nG46X0.Y0.\nG46X9.Y0.\nG46X0.Y9.\nM01\nM08\n";

TEST(StoredCorrections, M51OfAnUnknownLabelIsRefused) {
  EXPECT_EQ(diagnostics_of("M51,4\n"), Texts{"p.exc:8:1: error[label-unknown]"});
}

TEST(StoredCorrections, M52WithoutM51IsRefused) {
  EXPECT_EQ(diagnostics_of("M52,3\n"), Texts{"p.exc:8:1: error[rewind-missing]"});
}

TEST(StoredCorrections, StoringALabelAgainNeedsANewRewind) {
  const std::string record = "M50,1\nM25\nG46X0.Y0.\nM01\nM08\n";
  EXPECT_EQ(diagnostics_of(record + "M51,1\n" + record + "M52\n"),
            Texts{"p.exc:19:1: error[rewind-missing]"});
}

/// "There must be as many M52 commands after an M51 as G36/G46".
TEST(StoredCorrections, AReplayWithoutM25OfSomeBoardsIsRefused) {
  const std::string record = measure_three_boards("G46X0.Y0.\n");  // lines 8 to 13
  const std::string part = "M51,1\nM52\nX1.Y1.\nX11.Y1.\nX21.Y1.\n";
  const auto left_in = [](int line) {
    return Texts{"p.exc:" + std::to_string(line) + ":1: error[points-left]"};
  };
  EXPECT_EQ(diagnostics_of(record + part), left_in(19));  // M30
  EXPECT_EQ(diagnostics_of(record + part + "G47\nX2.Y2.\n"), left_in(21));
  EXPECT_EQ(diagnostics_of(record + part + part), left_in(19));
  EXPECT_EQ(diagnostics_of(record + part + record), left_in(19));
  EXPECT_EQ(diagnostics_of(record + part + "M25\nX2.Y2.\n" + kThreeBoards),
            Texts{"p.exc:20:1: error[advance-missing]"});
}

TEST(StoredCorrections, M52BeyondTheLastPointIsRefused) {
  EXPECT_EQ(diagnostics_of(std::string(kStoreThree) + "M51,1\nM52,2\nM52,2\n", 3),
            Texts{"p.exc:17:1: error[points-exhausted]"});
}

TEST(StoredCorrections, ACoordinateInsideAStoredSeriesNamesBothLines) {
  EXPECT_EQ(diagnostics_of(std::string(kStoreThree) + "M51,1\nM52,2\nT2\nX1.Y1.\n", 3),
            Texts{"p.exc:18:1: error[pointer-inside-series]"});
}

TEST(StoredCorrections, ANestedOneUnderAnotherBaseIsRefused) {
  const std::string store = "G35X0.Y0.\nM50,1\nM25\nG45X0.Y0.\nM01\nM08\n";
  const std::string expected = "error[nested-base-changed]";
  EXPECT_EQ(diagnostics_of(store + "G35X0.Y0.\nM51,1\nM52\n"), Texts{"p.exc:16:1: " + expected});
  EXPECT_EQ(diagnostics_of(store + "G37\nM51,1\nM52\n"), Texts{"p.exc:16:1: " + expected});
}

}  // namespace
}  // namespace panelcal
