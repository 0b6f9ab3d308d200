// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "program/walk/walk.h"
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/random/naive_expander.h"
#include "tests/program/random/random_program.h"

namespace panelcal {
namespace {

using test::FunctionSource;
using test::Hole;
using test::naive_holes;
using test::ProgramRun;
using test::run_program;
using test::Steps;

/// Doubles of up to 100 inch, added up a few times.
constexpr double kRounding_mm = 1e-9;

std::string program(const std::string& body) {
  return "M48\nINCH,LZ\nT1C.04\n%\nT1\n" + body + "M30\n";
}

std::string corrected_program(const std::string& body) {
  return "M48\nINCH,LZ\nT1C.04\n%\nT1\nG34,1\nG36X.1Y.1\nG36X9.Y.2\nG36X.3Y8.\n" + body + "M30\n";
}

/// A panel that was laid down turned and shifted.
struct Rigid {
  double angle_rad;
  Eigen::Vector2d shift_mm;

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    return {c * p.x() - s * p.y() + shift_mm.x(), s * p.x() + c * p.y() + shift_mm.y()};
  }
};

Rigid any_rigid() {
  const auto small = [](double most) { return most * (*rc::gen::inRange(-1000, 1001)) / 1000; };
  const double angle_rad = small(0.1);
  const double x_mm = small(20);
  return {angle_rad, {x_mm, small(20)}};
}

FunctionSource on(const Rigid& panel) {
  return FunctionSource(
      [panel](const MeasurementRequest& request) { return panel(request.nominal.in_mm()); });
}

void require_clean(const ProgramRun& run) {
  if (!run.diagnostics.empty()) RC_LOG(run.diagnostics.front());
  RC_ASSERT(run.diagnostics.empty());
}

RC_GTEST_PROP(Walk, DrillsWhatANaiveExpansionDrills, ()) {
  const std::string body = *test::random_body();
  const ProgramRun run = run_program(program(body));
  require_clean(run);
  const std::vector<Steps> expected = naive_holes(body);
  RC_ASSERT(run.holes().size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Eigen::Vector2d expected_mm =
        Eigen::Vector2d(static_cast<double>(expected[i].x), static_cast<double>(expected[i].y)) *
        (25.4 / 10000);
    RC_ASSERT((run.holes()[i].nominal_mm() - expected_mm).norm() < kRounding_mm);
    RC_ASSERT(run.holes()[i].actual_mm() == run.holes()[i].nominal_mm());
  }
}

RC_GTEST_PROP(Walk, ARigidCorrectionCommutesWithInterpretation, ()) {
  const std::string body = *test::random_body();
  const Rigid panel = any_rigid();
  const ProgramRun plain = run_program(program(body));
  FunctionSource source = on(panel);
  const ProgramRun corrected = run_program(corrected_program(body), {}, source);
  require_clean(corrected);
  RC_ASSERT(corrected.holes().size() == plain.holes().size());
  for (std::size_t i = 0; i < plain.holes().size(); ++i) {
    const Eigen::Vector2d expected_mm = panel(plain.holes()[i].nominal_mm());
    RC_ASSERT(corrected.holes()[i].nominal_mm() == plain.holes()[i].nominal_mm());
    RC_ASSERT((corrected.holes()[i].corrected_mm() - expected_mm).norm() < kRounding_mm);
  }
}

RC_GTEST_PROP(Walk, NestedTargetsOnARigidPanelChangeNothing, ()) {
  const std::string body = *test::random_vision_body();
  const Rigid panel = any_rigid();
  FunctionSource source = on(panel);
  const ProgramRun run = run_program(corrected_program(body), {}, source);
  require_clean(run);
  for (const Hole& hole : run.holes()) {
    RC_ASSERT((hole.corrected_mm() - panel(hole.nominal_mm())).norm() < kRounding_mm);
  }
}

RC_GTEST_PROP(Walk, EveryTargetOfEveryCopyIsMeasuredOnce, ()) {
  const std::string body = *test::random_vision_body();
  const ProgramRun run = run_program(corrected_program(body));
  require_clean(run);
  // A target is a hole to the naive expander, once the words in front are gone.
  std::string targets;
  std::istringstream lines(body);
  for (std::string line; std::getline(lines, line);) {
    const bool is_target = line.starts_with("G46") || line.starts_with("G48");
    const bool is_frame = line.starts_with("M") || line.find("M02") != std::string::npos;
    if (is_target) targets += line.substr(3) + "\n";
    if (is_frame) targets += line + "\n";
  }
  const std::size_t n_targets = naive_holes(targets).size() + 3;
  RC_ASSERT(run.survey.measurements.size() == n_targets);
  for (std::size_t i = 0; i < n_targets; ++i) {
    RC_ASSERT(run.survey.measurements[i].request.seq == static_cast<std::int64_t>(i));
  }
  std::set<std::size_t> used;
  for (const SeriesResult& series : run.survey.series) {
    for (const std::size_t i : series.measurements) RC_ASSERT(used.insert(i).second);
  }
  const auto n_holes_at_targets = static_cast<std::size_t>(std::ranges::count_if(
      run.survey.measurements,
      [](const Measurement& measurement) { return measurement.request.command == "G48"; }));
  RC_ASSERT(used.size() + n_holes_at_targets == n_targets);
}

RC_GTEST_PROP(Walk, TwoExecutionsAreIdentical, ()) {
  const std::string body = *test::random_vision_body();
  FunctionSource source = on(any_rigid());
  const ProgramRun first = run_program(corrected_program(body), {}, source);
  require_clean(first);
  test::Recorder second;
  DiagnosticLog log;
  execute(first.program, {}, first.survey, second, log);
  RC_ASSERT(second.lines() == first.executed.lines());
}

RC_GTEST_PROP(Walk, LineEndsChangeNothing, ()) {
  const std::string body = *test::random_vision_body();
  std::string windows;
  for (const char c : program("G34,1\n" + body)) windows += c == '\n' ? "\r\n" : std::string(1, c);
  RC_ASSERT(run_program(windows).executed.lines() ==
            run_program(program("G34,1\n" + body)).executed.lines());
}

TEST(NaiveExpander, AgreesWithAnExampleByHand) {
  const std::string body = "X1.0Y2.0\nM25\nX.5Y.25\nR1X.1\nM01\nM02X1.Y0.M80\nM01\nR1M02Y3.\nM08\n";
  const std::vector<Steps> expected = {{10000, 20000},
                                       {5000, 2500},
                                       {6000, 2500},
                                       {5000, 2500},
                                       {4000, 2500},
                                       {5000, 32500},
                                       {6000, 32500},
                                       {5000, 32500},
                                       {4000, 32500}};
  EXPECT_EQ(naive_holes(body), expected);
}

}  // namespace
}  // namespace panelcal
