// SPDX-License-Identifier: Apache-2.0
// Surface commands that the manual names without an example: G72, G76, G77, BOTR and BOTT.
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panelcal/program/probing.h"
#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using test::expect_refused;
using test::format_5000;
using test::ProgramRun;
using test::run_program;
using test::steps_of;
using testing::ElementsAre;

/// Heights in the order of probing, mm.
class Heights final : public ProbeSource {
 public:
  explicit Heights(std::vector<double> heights_mm) : heights_mm_(std::move(heights_mm)) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    const double height_mm = heights_mm_.at(static_cast<std::size_t>(request.seq));
    return ProbeReading{request, ProbeStatus::Found, {{mm(height_mm), um(1)}}, ""};
  }

 private:
  std::vector<double> heights_mm_;
};

ProgramRun run_with(const std::string& body, std::vector<double> heights_mm) {
  DiagnosticLog log;
  ProgramRun run;
  run.program = load_program({"p.exc", format_5000(body)}, log);
  NominalSource targets;
  Heights probes(std::move(heights_mm));
  run.survey = survey(run.program, {}, targets, probes, log);
  run.has_errors = log.has_errors();
  if (!run.has_errors) execute(run.program, {}, run.survey, run.executed, log);
  for (const Diagnostic& diagnostic : log.kept()) run.diagnostics.push_back(diagnostic.text());
  return run;
}

/// A 2 x 2 grid about (5, 5), 0.2 mm higher on its right side than at the reference.
const std::string kGrid = "XYG78\nXYG79\nX10.YG79\nXY10.G79\nX10.Y10.G79\n";
const std::vector<double> kGridHeights = {1.6, 1.6, 1.8, 1.6, 1.8};

/// "Measure depth/residual web and record deviation": it changes no reference.
TEST(SurfaceCommands, G76OnlyRecords) {
  const ProgramRun run = run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G76\nX3.Y3.T1\nG70\n", {1.6, 1.9});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.survey.probes.size(), 2U);
  EXPECT_EQ(run.survey.probes[1].request.command, "G76");
  EXPECT_EQ(run.survey.probes[1].heights[0].height, mm(1.9));
  EXPECT_THAT(steps_of(run), ElementsAre("tool 1", "drill 1 (3, 3) depth 0.4 surface 1.6"));
}

/// "Deactivate surface detection for one block."
TEST(SurfaceCommands, G77TakesNoAccountOfTheSurfaceInItsLine) {
  const ProgramRun slm = run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.T1Z.5G77\nX3.Y3.\nG70\n", {1.6});
  ASSERT_FALSE(slm.has_errors) << testing::PrintToString(slm.diagnostics);
  EXPECT_THAT(
      steps_of(slm),
      ElementsAre("tool 1", "drill 1 (2, 2) z 0.5", "drill 1 (3, 3) depth 0.4 surface 1.6"));
  const ProgramRun grid = run_with(kGrid + "X10.Y5.T1Z.5\nX10.Y6.G77\nX10.Y7.\n", kGridHeights);
  ASSERT_FALSE(grid.has_errors) << testing::PrintToString(grid.diagnostics);
  EXPECT_THAT(steps_of(grid),
              ElementsAre("tool 1",
                          "drill 1 (10, 5) z 0.7 surface 1.8",
                          "drill 1 (10, 6) z 0.5",
                          "drill 1 (10, 7) z 0.7 surface 1.8"));
}

/// G72 forgets the stored values, not the reference in force.
TEST(SurfaceCommands, G72ForgetsWhatWasStored) {
  const ProgramRun run =
      run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G73L2\nG72\nX3.Y3.T1\nX4.Y4.G73L1\nL1\nX5.Y5.\nG70\n",
               {1.6, 1.7, 1.8});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (3, 3) depth 0.4 surface 1.7",
                          "drill 1 (5, 5) depth 0.4 surface 1.8"));
  expect_refused(run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G73L2\nG72\nL2\nX3.Y3.T1\nG70\n", {1.6, 1.7}),
                 6,
                 {"L2"});
}

/// Without G78 the grid's heights count from BOTR; then BOTT holds them against it.
TEST(SurfaceCommands, BotrIsTheReferenceOfTheGrid) {
  const std::string grid = "XYG79\nX10.YG79\nXY10.G79\nX10.Y10.G79\nX5.Y5.T1Z.5\n";
  const ProgramRun run = run_with("M49,BOTR1.5\n" + grid, {1.6, 1.6, 1.6, 1.6});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run),
              ElementsAre("setting M49,BOTR1.5", "tool 1", "drill 1 (5, 5) z 0.6 surface 1.6"));
  EXPECT_EQ(run.survey.probes[0].request.reference, mm(1.5));
  const ProgramRun refused = run_with("M49,BOTR1.5\nM49,BOTT0.05\n" + grid, {1.54, 1.56, 1.6, 1.6});
  expect_refused(refused, 5, {"BOTT"});
}

}  // namespace
}  // namespace panelcal
