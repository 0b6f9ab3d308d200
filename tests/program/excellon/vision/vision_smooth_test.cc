// SPDX-License-Identifier: Apache-2.0
// [vision] model = "smooth", and where "auto" takes it.
#include <cmath>
#include <string>
#include <vector>

#include "calib/correction/error_budget.h"
#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::Reports;
using test::run_program;
using testing::ElementsAre;

constexpr int kTargets = 16;
constexpr const char* kHoles = "X35.Y40.\nX150.Y100.\nX299.Y-5.\n";

enum class Model { Smooth, Auto, Affine };

WalkOptions options_for(Model model, int series_size = kTargets) {
  WalkOptions options;
  options.series_size = series_size;
  options.bends_panel = model == Model::Smooth;
  options.chooses_model = model == Model::Auto;
  if (model == Model::Affine) options.model = PanelModel::Affine;
  return options;
}

/// Four by four on 300 x 240 mm.
std::string targets() {
  std::string text;
  for (int i = 0; i < kTargets; ++i) {
    text += fmt::format("G36X{}.Y{}.\n", 100 * (i % 4), 80 * (i / 4));
  }
  return text;
}

Vector2d affine(const Vector2d& p_mm) {
  return {1.0002 * p_mm.x() + 0.0003 * p_mm.y() + 0.4, 0.9999 * p_mm.y() - 0.3};
}

/// A bow of some 0.1 mm, 100 times what a target is known to.
Vector2d bowed(const Vector2d& p_mm) {
  const double x = p_mm.x() / 150 - 1;
  const double y = p_mm.y() / 120 - 1;
  return affine(p_mm) + Vector2d(0.05 * x * x + 0.04 * x * y, 0.06 * y * y - 0.05 * x * x);
}

/// Pseudo-random errors of about the micrometre that targets are said to have.
Vector2d noise(std::int64_t seq) {
  const auto of = [](double a) { return 0.0017 * (a - std::floor(a)) * 2 - 0.0017; };
  const auto n = static_cast<double>(seq);
  return {of(0.618034 * (n + 1)), of(0.754878 * (n + 1))};
}

ProgramRun run(std::string_view body,
               const WalkOptions& options,
               const std::function<Vector2d(const Vector2d&)>& panel,
               bool is_noisy = false) {
  FunctionSource source([&](const MeasurementRequest& request) -> Vector2d {
    const Vector2d seen_mm = panel(request.nominal.in_mm());
    return is_noisy ? Vector2d(seen_mm + noise(request.seq)) : seen_mm;
  });
  return run_program(metric("G34,1\nT1\n" + std::string(body) + "M30\n"), options, source);
}

TEST(VisionSmooth, DrillsAnAffinePanelAsAnAffineModelDoes) {
  const std::string body = targets() + kHoles;
  const ProgramRun smooth = run(body, options_for(Model::Smooth), affine);
  const ProgramRun straight = run(body, options_for(Model::Affine), affine);
  ASSERT_TRUE(smooth.diagnostics.empty()) << smooth.diagnostics.front();
  EXPECT_TRUE(smooth.survey.series.at(0).is_smooth());
  EXPECT_FALSE(straight.survey.series.at(0).is_smooth());
  ASSERT_EQ(smooth.holes().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((smooth.holes()[i].corrected_mm() - straight.holes()[i].corrected_mm()).norm(), 1e-9);
    EXPECT_LT((smooth.holes()[i].actual_mm() - straight.holes()[i].actual_mm()).norm(), 1e-9);
    // It cannot know that the panel is not bent.
    EXPECT_GT(smooth.holes()[i].drill.cov_mm2.trace(), straight.holes()[i].drill.cov_mm2.trace());
  }
}

TEST(VisionSmooth, FollowsABowedPanel) {
  const std::string body = targets() + kHoles;
  const ProgramRun smooth = run(body, options_for(Model::Smooth), bowed);
  const ProgramRun straight = run(body, options_for(Model::Affine), bowed);
  double smooth_mm = 0, straight_mm = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2d right_mm = bowed(smooth.holes().at(i).nominal_mm());
    smooth_mm += (smooth.holes()[i].corrected_mm() - right_mm).norm();
    straight_mm += (straight.holes().at(i).corrected_mm() - right_mm).norm();
  }
  EXPECT_LT(smooth_mm, 0.25 * straight_mm);
}

TEST(VisionSmooth, GatesStretchAndOffsetByItsAffinePartAndResidualsByItself) {
  WalkOptions options = options_for(Model::Smooth);
  options.base_limits.residual = um(20);
  options.base_limits.stretch_ppm = 100;
  const ProgramRun found = run(targets(), options, bowed);
  const SeriesResult& series = found.survey.series.at(0);
  ASSERT_EQ(series.gates.size(), 2u);
  EXPECT_TRUE(series.gates[0].accepted) << series.gates[0].text();  // an affine fit leaves 100 um
  EXPECT_FALSE(series.gates[1].accepted);
  EXPECT_FALSE(all_accepted(run(
                                targets(),
                                [&] {
                                  WalkOptions affine_options = options_for(Model::Affine);
                                  affine_options.base_limits.residual = um(20);
                                  return affine_options;
                                }(),
                                bowed)
                                .survey.series.at(0)
                                .gates));
}

TEST(VisionSmooth, NeedsSixTargetsButNotOfASingleOne) {
  const std::string five = "G36X0.Y0.\nG36X300.Y0.\nG36X300.Y200.\nG36X0.Y200.\nG36X90.Y80.\n";
  const ProgramRun refused = run(five + kHoles, options_for(Model::Smooth, 5), affine);
  EXPECT_THAT(refused.texts,
              ElementsAre(Reports("p.exc:8:1: error[targets-too-few]", "5", "\"smooth\"")));
  EXPECT_TRUE(refused.holes().empty());
  const ProgramRun single =
      run("G35X10.Y10.\n" + std::string(kHoles), options_for(Model::Smooth), affine);
  EXPECT_TRUE(single.diagnostics.empty());
  EXPECT_EQ(single.survey.series.at(0).model, PanelModel::Offset);
}

TEST(VisionSmooth, RefusesNestedSeriesOnTop) {
  const ProgramRun found =
      run(targets() + "G45X20.Y20.\n" + kHoles, options_for(Model::Smooth), bowed);
  EXPECT_THAT(found.diagnostics, ElementsAre("p.exc:24:1: error[nested-on-smooth]"));
}

TEST(VisionSmooth, RefusesToFoldThePanel) {
  const auto exchanged = [](const Vector2d& p_mm) {
    if (p_mm == Vector2d(100, 80)) return affine({200, 80});
    return p_mm == Vector2d(200, 80) ? affine({100, 80}) : affine(p_mm);
  };
  const ProgramRun found = run(targets() + kHoles, options_for(Model::Smooth), exchanged);
  EXPECT_THAT(found.diagnostics, ElementsAre("p.exc:8:1: error[panel-folded]"));
}

TEST(VisionSmooth, BudgetsAddUpToTheHolesCovariance) {
  WalkOptions options = options_for(Model::Smooth);
  MachineUncertainty& machine = options.uncertainty;
  machine.stage_repeatability = um(1.5);
  machine.table_residual = um(2);
  machine.drill_wander = um(2.5);
  machine.spindle_camera_mm2 << 1.5e-6, 0.4e-6, 0.4e-6, 1e-6;
  for (const Model model : {Model::Smooth, Model::Auto}) {
    options.bends_panel = model == Model::Smooth;
    options.chooses_model = model == Model::Auto;
    const ProgramRun found = run(targets() + kHoles, options, bowed, true);
    ASSERT_TRUE(found.survey.series.at(0).is_smooth());
    CorrectionStack stack(machine);
    stack.set_base(found.survey.series.at(0).base);
    for (const test::Hole& hole : found.holes()) {
      const ErrorBudget budget = error_budget(stack, hole.drill.nominal);
      EXPECT_THAT(total_mm2(budget), test::IsNearMatrix(hole.drill.cov_mm2, 1e-12));
      for (const BudgetTerm& term : budget) {
        EXPECT_GE(term.cov_mm2.trace(), 0) << term.source;
        EXPECT_GE(term.cov_mm2.determinant(), -1e-16) << term.source;
      }
      EXPECT_EQ(budget.at(9).source, "bending between targets");
      EXPECT_GT(budget[9].cov_mm2.trace(), 0);
    }
  }
}

TEST(VisionSmooth, IsChosenForABowedPanelAndNotForAnAffineOne) {
  const ProgramRun bent = run(targets() + kHoles, options_for(Model::Auto), bowed, true);
  EXPECT_TRUE(bent.survey.series.at(0).is_smooth());
  EXPECT_TRUE(bent.survey.series.at(0).chose_model);
  const ProgramRun straight = run(targets() + kHoles, options_for(Model::Auto), affine, true);
  EXPECT_FALSE(straight.survey.series.at(0).is_smooth());
  EXPECT_TRUE(straight.survey.series.at(0).chose_model);
}

TEST(VisionSmooth, IsNotChosenToFollowALiar) {
  const auto lying = [](const Vector2d& p_mm) {
    return Vector2d(affine(p_mm) +
                    (p_mm == Vector2d(100, 80) ? Vector2d(0.2, 0.1) : Vector2d(0, 0)));
  };
  const ProgramRun found = run(targets() + kHoles, options_for(Model::Auto), lying, true);
  EXPECT_FALSE(found.survey.series.at(0).is_smooth());
}

TEST(VisionSmooth, CutsRoutsToFollowTheBow) {
  constexpr const char* kRout =
      "G00X10.Y20.\nM15\nG01X290.Y210.\nG02X150.Y60.A150.\nG01X10.Y20.\nM16\n";
  const ProgramRun found = run(targets() + kRout, options_for(Model::Smooth), bowed);
  ASSERT_TRUE(found.diagnostics.empty()) << found.diagnostics.front();
  const auto& panel = *found.survey.series.at(0).base->smooth;
  const std::vector<Rout>& routs = found.executed.routs();
  EXPECT_GT(routs.size(), 6u);
  EXPECT_LT(routs.size(), 60u);
  Position<frame::Nominal> from = position_mm<frame::Nominal>(10, 20);
  for (const Rout& rout : routs) {
    EXPECT_LT((panel.map(rout.nominal).in_mm() - rout.corrected.in_mm()).norm(), 1e-9);
    EXPECT_GT(rout.cov_mm2.determinant(), 0);
    if (rout.kind == RoutKind::Line) {
      const Vector2d start_mm = panel.map(from).in_mm();
      const Vector2d along = (rout.corrected.in_mm() - start_mm).normalized();
      const Vector2d middle_mm = panel
                                     .map(position_mm<frame::Nominal>(
                                         Vector2d(0.5 * (from.in_mm() + rout.nominal.in_mm()))))
                                     .in_mm() -
                                 start_mm;
      EXPECT_LT(std::abs(along.x() * middle_mm.y() - along.y() * middle_mm.x()), 0.00101);
    }
    from = rout.nominal;
  }
  EXPECT_EQ(from.in_mm(), Vector2d(10, 20));
}

}  // namespace
}  // namespace panelcal
