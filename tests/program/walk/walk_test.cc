// SPDX-License-Identifier: Apache-2.0
#include "program/walk/walk.h"

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/folders.h"

namespace panelcal {
namespace {

using test::Recorder;

Recorder executed(const Program& program) {
  DiagnosticLog log;
  NominalSource source;
  const Survey found = survey(program, {}, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept()[0].text();
  Recorder recorder;
  execute(program, {}, found, recorder, log);
  return recorder;
}

// Strings this short live inside their object, so that moving it moves the bytes.
constexpr char kShort[] = "T1\nXY\nM30\n";

TEST(Walk, AProgramMayBeMovedAndCopied) {
  DiagnosticLog log;
  auto first = std::make_unique<Program>(load_program({"p", kShort}, log));
  const Program copied = *first;
  const Program moved = std::move(*first);
  first.reset();
  EXPECT_EQ(executed(copied).lines().size(), 3U);
  EXPECT_EQ(executed(moved).lines(), executed(copied).lines());
}

TEST(Walk, AnEmptyProgramHasNoEnd) {
  EXPECT_EQ(test::run_program("").diagnostics,
            std::vector<std::string>{"p.exc:1: error[end-missing]"});
}

TEST(Walk, TheSinkLearnsFileAndToolsBeforeAnythingElse) {
  class First final : public OperationSink {
   public:
    void begin(const ProgramInfo& info) override { info_ = info; }
    void put(const Operation&) override { has_put_ = true; }
    ProgramInfo info_;
    bool has_put_ = false;
  };
  DiagnosticLog log;
  const Program program = load_program({"p.exc", "M48\nINCH,LZ\nT1C.04\nT7C.08\n%\nM30\n"}, log);
  First first;
  execute(program, {}, {}, first, log);
  EXPECT_EQ(first.info_.file, "p.exc");
  EXPECT_EQ(first.info_.format.unit, LengthUnit::Inch);
  EXPECT_EQ(first.info_.tools.size(), 2U);
  EXPECT_TRUE(first.has_put_);
}

TEST(Walk, TheDemoPanelHasTheHolesThatItsOriginStates) {
  const auto source = read_source(test::source_folder() / "datasets/demo/panel.exc");
  ASSERT_TRUE(source);
  const test::ProgramRun run = test::run_program(source->bytes);
  EXPECT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  EXPECT_EQ(run.survey.measurements.size(), 3U + 18U);
  std::map<int, int> hits;
  for (const test::Hole& hole : run.holes()) ++hits[hole.drill.tool];
  EXPECT_EQ(hits,
            (std::map<int, int>{{1, 312}, {2, 162}, {3, 372}, {4, 48}, {5, 12}, {6, 12}, {7, 72}}));
}

TEST(Survey, IsCompleteAndAcceptedWithoutVision) {
  EXPECT_TRUE(Survey{}.is_complete());
  EXPECT_TRUE(Survey{}.is_accepted());
}

TEST(Survey, AnUnfittedSeriesIsNotAccepted) {
  EXPECT_FALSE(SeriesResult{}.is_fitted());
  EXPECT_FALSE(SeriesResult{}.is_accepted());
  Survey survey;
  survey.series.emplace_back();
  EXPECT_FALSE(survey.is_complete());
}

TEST(Survey, ARefusingGateIsCompleteButNotAccepted) {
  SeriesResult series;
  series.base = std::make_shared<const BaseFit>();
  series.gates.push_back({.gate = "offset", .accepted = false});
  Survey survey;
  survey.series.push_back(series);
  EXPECT_TRUE(survey.is_complete());
  EXPECT_FALSE(survey.is_accepted());
}

}  // namespace
}  // namespace panelcal
