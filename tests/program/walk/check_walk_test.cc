// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "program/walk/walk.h"
#include <gtest/gtest.h>

#include "tests/calib/table/table_of.h"
#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::FunctionSource;
using test::Recorder;

constexpr std::string_view kHead = "M48\nMETRIC,TZ\nT1C0.8F100\nT2C1.0F100\n%\n";

Program program_of(std::string_view body) {
  DiagnosticLog log;
  Program program = load_program({"test.exc", std::string(kHead) + std::string(body)}, log);
  EXPECT_FALSE(log.has_errors());
  return program;
}

CheckedWalk checked(const Program& program,
                    Execution execution,
                    OperationSink& sink,
                    const WalkOptions& options = {}) {
  DiagnosticLog log;
  CheckedWalk walk = check(program, options, execution, &sink, log);
  EXPECT_FALSE(log.has_errors());
  return walk;
}

std::vector<std::string> executed(const Program& program, const Survey& survey) {
  Recorder recorder;
  DiagnosticLog log;
  execute(program, {}, survey, recorder, log);
  EXPECT_FALSE(log.has_errors());
  return recorder.lines();
}

TEST(CheckWalk, ExecutesAProgramThatAsksNothing) {
  const Program program = program_of(
      "T1\nX1Y2\nR3X1\nX5Y5G85X8Y5\nT2\nG00X0Y0\nM15\nG01X5\nG03X10Y5A5\nM16\nG05\nX7Y7\nM30\n");
  Recorder recorder;
  const CheckedWalk walk = checked(program, Execution::UntilAsked, recorder);
  EXPECT_TRUE(walk.is_executed);
  EXPECT_FALSE(walk.asks);
  EXPECT_EQ(recorder.lines(), executed(program, walk.survey));
}

TEST(CheckWalk, StopsExecutingWhereATargetIsMeasured) {
  const Program program = program_of("T1\nX1Y2\nG34,1\nG35X0Y0\nX2Y2\nM30\n");
  Recorder recorder;
  const CheckedWalk walk = checked(program, Execution::UntilAsked, recorder);
  EXPECT_FALSE(walk.is_executed);
  EXPECT_TRUE(walk.asks);
  EXPECT_EQ(recorder.holes().size(), 1u);
  EXPECT_EQ(walk.survey.measurements.size(), 1u);
}

/// The hole of the very block that asks: its place is what only a panel can tell.
TEST(CheckWalk, StopsExecutingAheadOfAHoleAtItsTarget) {
  DiagnosticLog log;
  for (const Program& program :
       {program_of("T1\nX1Y2\nG34,1\nG38X4Y4\nM30\n"),
        load_program({"p.s5", "%%5000\nX1.Y2.T1\nX4.Y4.G36\nX5.Y5.\n$\nT1D1.\n$\n"}, log)}) {
    Recorder recorder;
    const CheckedWalk walk = checked(program, Execution::UntilAsked, recorder);
    EXPECT_FALSE(walk.is_executed);
    EXPECT_EQ(recorder.holes().size(), 1u);
    EXPECT_EQ(walk.survey.measurements.size(), 1u);
  }
}

TEST(CheckWalk, ExecutesTargetsOnAPerfectPanelIfAsked) {
  const Program program =
      program_of("T1\nX1Y2\nG34,1\nG36X0Y0\nG36X9Y0\nG36X9Y9\nX2Y2\nG38X4Y4\nG37\nX3Y3\nM30\n");
  Recorder recorder;
  const CheckedWalk walk = checked(program, Execution::OfNominal, recorder);
  EXPECT_TRUE(walk.is_executed);
  EXPECT_EQ(recorder.lines(), executed(program, walk.survey));
}

TEST(CheckWalk, StopsExecutingWhereASectionIsRepeated) {
  const Program program = program_of("T1\nX1Y2\nM25\nX2Y2\nM01\nM02X5\nM08\nX3Y3\nM30\n");
  Recorder recorder;
  const CheckedWalk walk = checked(program, Execution::OfNominal, recorder);
  EXPECT_FALSE(walk.is_executed);
  EXPECT_EQ(recorder.holes().size(), 1u);
}

TEST(CheckWalk, KeepsProblemsOfWorkingApart) {
  const Program program = program_of("T1\nX1Y2\nX2000.Y2.\nM30\n");
  const TableGrid grid{Eigen::Vector2d(0, 0), Eigen::Vector2d(500, 400), 10, 8};
  const auto no_error_mm = [](const Eigen::Vector2d&) -> Eigen::Vector2d { return {0, 0}; };
  WalkOptions options;
  options.table =
      std::make_shared<const TableCorrection>(test::table_of(grid, no_error_mm), Length());
  Recorder recorder;
  const CheckedWalk walk = checked(program, Execution::UntilAsked, recorder, options);
  EXPECT_TRUE(walk.is_executed);
  ASSERT_EQ(walk.working_log.n_errors(), 1u);
  EXPECT_EQ(walk.working_log.kept().front().place.line, 8);
}

TEST(SurveyOfAChecked, EndsWhereTheProgramAsksForNothingMore) {
  const Program program = program_of(
      "T1\nG34,1\nG36X0Y0\nG36X9Y0\nG36X9Y9\nM25\nG45X1Y1\nX2Y2\nM01\nM02X5\nM08\nX3Y3\nX4Y4\n"
      "M30\n");
  const auto measured_mm = [](const MeasurementRequest& request) -> Eigen::Vector2d {
    return 1.0001 * request.nominal.in_mm() + Eigen::Vector2d(0.1, -0.2);
  };
  Recorder ignored;
  const CheckedWalk walk = checked(program, Execution::UntilAsked, ignored);
  ASSERT_TRUE(walk.asks_until);
  EXPECT_EQ(program.source.bytes.substr(*walk.asks_until), "X3Y3\nX4Y4\nM30\n");
  FunctionSource whole_source(measured_mm);
  FunctionSource short_source(measured_mm);
  NominalProbeSource probes;
  DiagnosticLog log;
  const Survey whole = survey(program, {}, whole_source, probes, log);
  const Survey early = survey(program, {}, walk, short_source, probes, log);
  EXPECT_FALSE(log.has_errors());
  EXPECT_EQ(measurement_lines(early), measurement_lines(whole));
  EXPECT_EQ(early.series.size(), whole.series.size());
  EXPECT_EQ(executed(program, early), executed(program, whole));
}

}  // namespace
}  // namespace panelcal
