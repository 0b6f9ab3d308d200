// SPDX-License-Identifier: Apache-2.0
// The programs of the CNC-7 manual's sections Vision Step and Repeat Examples and Part Program
// Vision Commands Examples, run on panels that lie crooked.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::Hole;
using test::ProgramRun;
using test::run_program;

using Texts = std::vector<std::string>;

constexpr char kHeader[] = "M48\nT1S20F09\nT2S20F09\nT3S20F09\n%\n";
constexpr char kPrealignment[] = "G34,1\nG36X-0087Y-007\nG36X-0087Y155\nG36X09Y155\n";
constexpr char kCopies[] = "M01\nM02X03\nM02X03\nM02\nM08\n";
constexpr char kBoardTargets[] = "G46XY\nG46XY02\nG46X02Y02\n";

std::string first_procedure() {
  return std::string(kHeader) + kPrealignment +                                        //
         "T1\nM50,1\nM25\n" + kBoardTargets + "X005Y005\nX0051Y0151\n" + kCopies +     //
         "T2\nM51,1\nM25\nM52,3\nX01Y005\nX0101Y0151\n" + kCopies +                    //
         "M50,2\nM25\nG46X015Y\nG46X01Y02\nG46X02Y03\nX01Y002\nX01Y018\n" + kCopies +  //
         "T3\nM51,1\nM25\nM52,3\nX015Y005\nX0151Y0151\n" + kCopies + "M30\n";
}

/// `last_target` is printed `G46X01Y02` a second time; the first procedure has `G46X02Y03` there.
std::string second_procedure(const std::string& last_target) {
  return std::string(kHeader) + kPrealignment +                                                  //
         "M50,1\nM25\n" + kBoardTargets + kCopies +                                              //
         "T1\nM51,1\nM25\nM52,3\nX005Y005\nX0051Y0151\n" + kCopies +                             //
         "T2\nM51,1\nM25\nM52,3\nX01Y005\nX0101Y0151\n" + kCopies +                              //
         "M50,2\nM25\nG46X015Y\nG46X01Y02\n" + last_target + "\nX01Y002\nX01Y018\n" + kCopies +  //
         "T3\nM51,1\nM25\nM52,3\nX015Y005\nX0151Y0151\n" + kCopies + "M30\n";
}

/// A panel that lies crooked and is stretched, on which every mark is off by its own 30 um. A mark
/// is known by its nominal place, so that it is always seen at the same one.
FunctionSource crooked_panel(std::uint64_t seed) {
  const Random random(seed);
  Random whole = random.fork(0);
  const double angle_rad = whole.uniform(-0.01, 0.01);
  const Vector2d shift_mm(whole.uniform(-1, 1), whole.uniform(-1, 1));
  Eigen::Matrix2d linear;
  linear << 1 + 2e-4 * whole.normal(), -angle_rad, angle_rad, 1 + 2e-4 * whole.normal();
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    const Vector2d& nominal_mm = request.nominal.in_mm();
    Random mark = random.fork(std::bit_cast<std::uint64_t>(nominal_mm.x()))
                      .fork(std::bit_cast<std::uint64_t>(nominal_mm.y()));
    const double x_mm = 0.03 * mark.normal();
    return linear * nominal_mm + shift_mm + Vector2d(x_mm, 0.03 * mark.normal());
  });
}

/// tool, nominal x and y, actual x and y: exactly as they are.
using ExactHole = std::tuple<int, double, double, double, double>;

std::vector<ExactHole> exact_holes(const ProgramRun& run) {
  std::vector<ExactHole> holes;
  for (const Hole& hole : run.holes()) {
    holes.emplace_back(hole.drill.tool,
                       hole.nominal_mm().x(),
                       hole.nominal_mm().y(),
                       hole.actual_mm().x(),
                       hole.actual_mm().y());
  }
  std::ranges::sort(holes);
  return holes;
}

std::map<int, int> hits(const ProgramRun& run) {
  std::map<int, int> count;
  for (const Hole& hole : run.holes()) ++count[hole.drill.tool];
  return count;
}

TEST(ManualVisionExamples, BothProceduresDrillTheSameHoles) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    FunctionSource first_panel = crooked_panel(seed);
    FunctionSource second_panel = crooked_panel(seed);
    const ProgramRun first = run_program(first_procedure(), {}, first_panel);
    const ProgramRun second = run_program(second_procedure("G46X02Y03"), {}, second_panel);
    EXPECT_EQ(first.diagnostics, Texts{});
    EXPECT_EQ(second.diagnostics, Texts{});
    ASSERT_EQ(first.holes().size(), 24U);
    EXPECT_EQ(exact_holes(first), exact_holes(second)) << "seed " << seed;
    EXPECT_EQ(hits(first), (std::map<int, int>{{1, 6}, {2, 12}, {3, 6}}));
    // The marks' own errors move the holes, each board in its own way.
    EXPECT_NE(first.holes()[0].actual_mm() - first.holes()[0].nominal_mm(),
              first.holes()[2].actual_mm() - first.holes()[2].nominal_mm());
  }
}

TEST(ManualVisionExamples, FirstProcedureMeasuresPanelThenBoards) {
  FunctionSource panel = crooked_panel(7);
  const ProgramRun run = run_program(first_procedure(), {}, panel);
  ASSERT_EQ(run.survey.measurements.size(), 3U + 3 * 3 + 3 * 3);
  ASSERT_EQ(run.survey.series.size(), 1U + 3 + 3);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(run.survey.series[i].level, i == 0 ? CorrectionLevel::Base : CorrectionLevel::Nested);
    EXPECT_EQ(run.survey.series[i].model, PanelModel::Stretch);
    EXPECT_EQ(run.survey.series[i].measurements.size(), 3U);
  }
  // Second board, second target: G46XY02 three inches to the right.
  const MeasurementRequest& request = panel.requests()[3 + 3 + 1];
  EXPECT_EQ(request.command, "G46");
  EXPECT_EQ(request.line, 14);
  EXPECT_EQ(request.path, InstancePath{1});
  EXPECT_NEAR(request.nominal.in_mm().x(), 3 * kMmPerInch, 1e-12);
  EXPECT_NEAR(request.nominal.in_mm().y(), 2 * kMmPerInch, 1e-12);
  // Nested targets are looked for where the base correction puts them.
  const Transform<frame::Base, frame::Nominal>& base = run.survey.series[0].base->map.map;
  EXPECT_EQ(request.expected.in_mm(), base(request.nominal).in_mm());
}

TEST(ManualVisionExamples, HolesAreCorrectedByTheirBoardsOwnTargets) {
  FunctionSource panel = crooked_panel(11);
  const ProgramRun run = run_program(first_procedure(), {}, panel);
  for (const Hole& hole : run.holes()) {
    // M50,2 is measured after T2's first section, its three boards are series 4 to 6.
    const bool is_second_set = hole.line == 39 || hole.line == 40;
    const SeriesResult& series =
        run.survey.series[static_cast<std::size_t>(hole.path[0]) + (is_second_set ? 4 : 1)];
    const auto corrected =
        series.nested->map.map(run.survey.series[0].base->map.map(hole.drill.nominal));
    EXPECT_LT((corrected.in_mm() - hole.corrected_mm()).norm(), 1e-9) << "line " << hole.line;
  }
}

TEST(ManualVisionExamples, SecondProcedureAsPrintedIsDegenerate) {
  FunctionSource panel = crooked_panel(1);
  const ProgramRun run = run_program(second_procedure("G46X01Y02"), {}, panel);
  // The slip as printed measures one mark twice; each of its three boards is refused, once.
  EXPECT_EQ(run.diagnostics, (Texts{"p.exc:44:1: error[series-degenerate]"}));
  EXPECT_FALSE(run.survey.is_complete());
  EXPECT_TRUE(run.holes().empty());
}

std::string uvis_program() {
  const std::string arrays = "M01\nR3M02X3.1Y\nM01\nR6M02XY2.9\nM08\n";
  return std::string(kHeader) +
         "$uvis,search,on\n$uvis,zoom,7\n$uvis,lamp,30\n$uvis,focus,xy\n$uvis,alg,0,2\n"
         "$uvis,zoom,3\n$uvis,calib\n$uvis,lamp,25\n$uvis,insp,2\nG34,1\nG36XY\nG36X8.6Y\n"
         "$uvis,search,off\nT1\nG34,2\n$uvis,zoom,7\n$uvis,calib\n$uvis,lamp,55\n$uvis,alg,0,3\n"
         "$uvis,insp,1\nM50,1\nM25\nG46XY\nG46X2.4Y\nG46X1.2Y2.4\nXY\n" +
         arrays + "T2\nM51,1\nM25\nM52,3\nX2.4Y\n" + arrays + "T3\nM51,1\nM25\nM52,3\nX1.2Y2.4\n" +
         arrays + "$uvis,lamp,0\nM30\n";
}

TEST(ManualUvisExample, CountsFollowFromItsArrays) {
  const ProgramRun run = run_program(uvis_program());
  ASSERT_FALSE(run.has_errors) << run.diagnostics.front();
  constexpr int kBoards = (3 + 1) * (6 + 1);
  EXPECT_EQ(run.survey.measurements.size(), 2U + 3U * kBoards);
  ASSERT_EQ(run.survey.series.size(), 1U + kBoards);
  EXPECT_EQ(run.survey.series[0].measurements.size(), 2U);
  EXPECT_EQ(run.survey.series[0].model, PanelModel::Rigid);
  EXPECT_EQ(run.survey.series[1].measurements.size(), 3U);
  EXPECT_EQ(run.survey.series[1].model, PanelModel::Stretch);
  EXPECT_EQ(hits(run), (std::map<int, int>{{1, kBoards}, {2, kBoards}, {3, kBoards}}));
  const Hole& last_of_t1 = run.holes()[kBoards - 1];
  EXPECT_EQ(last_of_t1.path, (InstancePath{6, 3}));
  EXPECT_NEAR(last_of_t1.nominal_inch().x(), 9.3, 1e-12);
  EXPECT_NEAR(last_of_t1.nominal_inch().y(), 17.4, 1e-12);
}

TEST(ManualUvisExample, SettingsReachTheRequestsTheyStandBefore) {
  FunctionSource panel = test::shifted_by(0, 0);
  run_program(uvis_program(), {}, panel);
  const VisionSettings& base = panel.requests()[1].settings;
  EXPECT_EQ(base.tools, std::vector<int>{1});
  EXPECT_EQ(base.search, true);
  EXPECT_EQ(base.zoom, 3);
  EXPECT_EQ(base.lamp, 25);
  EXPECT_EQ(base.inspections, 2);
  EXPECT_EQ(base.algorithm, 0);
  const VisionSettings& nested = panel.requests()[2].settings;
  EXPECT_EQ(nested.tools, std::vector<int>{2});
  EXPECT_EQ(nested.search, false);
  EXPECT_EQ(nested.zoom, 7);
  EXPECT_EQ(nested.lamp, 55);
  EXPECT_EQ(nested.inspections, 1);
}

TEST(ManualUvisExample, SaysThatNothingIsCalibratedOrFocused) {
  const ProgramRun run = run_program(uvis_program());
  EXPECT_EQ(run.diagnostics,
            (Texts{"p.exc:9:1: warning[calibration-not-performed]",
                   "p.exc:12:1: warning[calibration-not-performed]",
                   "p.exc:22:1: warning[calibration-not-performed]"}));
}

TEST(ManualUvisExample, OrdersArePassedOnInTheirPlace) {
  const ProgramRun run = run_program(uvis_program());
  const Texts& lines = run.executed.lines();
  EXPECT_EQ(lines[0], "5 header_end");
  EXPECT_EQ(lines[1], "6 setting $uvis,search,on");
  EXPECT_EQ(lines[lines.size() - 2], "57 setting $uvis,lamp,0");
  EXPECT_EQ(std::ranges::count_if(
                lines, [](const std::string& line) { return line.find("$uvis") != line.npos; }),
            16);
}

}  // namespace
}  // namespace panelcal
