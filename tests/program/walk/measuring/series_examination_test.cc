// SPDX-License-Identifier: Apache-2.0
#include "program/walk/measuring/series_examination.h"

#include <string>

#include "program/walk/measuring/pad_collector.h"
#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::run_program;
using test::says;

/// Four targets from line 8 on that are not symmetric, one hole near the third; sources answer with
/// a sigma of about a micrometre.
const std::string kBody =
    "G34,1\nT1\nG36X0.Y0.\nG36X200.Y0.\nG36X190.Y150.\nG36X0.Y160.\nX192.Y151.5\nX50.Y50.\nM30\n";
constexpr int kThirdLine = 10;

WalkOptions examining(int max_dropped = 0) {
  WalkOptions options;
  options.series_size = 4;
  options.base_limits.rotation = rad(0.005);
  options.base_limits.stretch_ppm = 300;
  options.base_limits.offset = mm(2);
  options.base_limits.false_alarm = 1e-3;
  options.base_limits.max_dropped = max_dropped;
  options.nested_limits = options.base_limits;
  return options;
}

/// The panel is 0.3 mm off in x, and the third target another 0.4 mm in x and 0.7 mm in y.
FunctionSource with_a_liar() {
  return FunctionSource([](const MeasurementRequest& request) -> Vector2d {
    Vector2d place = request.nominal.in_mm() + Vector2d(0.3, 0);
    if (request.line == kThirdLine) place += Vector2d(0.4, 0.7);
    return place;
  });
}

TEST(SeriesExamination, RefusesAndNamesTheLiar) {
  FunctionSource source = with_a_liar();
  const ProgramRun run = run_program(metric(kBody), examining(), source);
  ASSERT_EQ(run.survey.series.size(), 1U);
  EXPECT_FALSE(run.survey.is_accepted());
  ASSERT_TRUE(run.survey.series[0].fault);
  EXPECT_EQ(run.survey.series[0].fault->i_outlier, 2U);
  EXPECT_THAT(run.diagnostics, testing::Contains(says(kThirdLine, "error[target-suspected]")));
}

/// The same on a panel that lies turned by a quarter or a half, as the job says.
TEST(SeriesExamination, TurnsBackWhatIsMeantToLieTurned) {
  for (const int turned_deg : {90, 180, 270}) {
    WalkOptions options = examining();
    options.base_limits.turned_deg = turned_deg;
    const auto lying = [turned_deg](double error_mm) {
      return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
        const Vector2d off(0.3, request.line == kThirdLine ? error_mm : 0);
        return turned_by(request.nominal.in_mm() + off, turned_deg);
      });
    };
    FunctionSource healthy = lying(0);
    EXPECT_TRUE(run_program(metric(kBody), options, healthy).survey.is_accepted()) << turned_deg;
    FunctionSource wrong = lying(0.7);
    const ProgramRun run = run_program(metric(kBody), options, wrong);
    ASSERT_TRUE(run.survey.series.at(0).fault) << turned_deg;
    EXPECT_EQ(run.survey.series[0].fault->i_outlier, 2U) << turned_deg;
  }
}

TEST(SeriesExamination, SaysNothingOfAHealthyPanel) {
  FunctionSource source = test::shifted_by(0.3, 0.1);
  const ProgramRun run = run_program(metric(kBody), examining(1), source);
  EXPECT_TRUE(run.survey.is_accepted());
  EXPECT_FALSE(run.survey.series[0].fault);
  EXPECT_TRUE(run.survey.series[0].dropped.empty());
}

TEST(SeriesExamination, LeavesTheLiarOutOnlyIfAllowed) {
  FunctionSource source = with_a_liar();
  const ProgramRun run = run_program(metric(kBody), examining(1), source);
  const SeriesResult& series = run.survey.series.at(0);
  EXPECT_FALSE(run.has_errors);
  EXPECT_TRUE(run.survey.is_accepted());
  EXPECT_EQ(series.dropped, std::vector<std::size_t>{2});
  EXPECT_EQ(series.points, (std::vector<std::size_t>{0, 1, 3}));
  EXPECT_EQ(series.base->residuals.size(), 3U);
  EXPECT_THAT(run.diagnostics, testing::Contains(says(kThirdLine, "warning[target-dropped]")));
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_LT((run.holes()[1].corrected_mm() - Vector2d(50.3, 50)).norm(), 1e-6);
}

/// Without a rate nothing is refused that was not before, and a gate that refuses is explained.
TEST(SeriesExamination, ExplainsWhatAGateRefuses) {
  FunctionSource source = with_a_liar();
  WalkOptions options = examining();
  options.base_limits.false_alarm.reset();
  options.base_limits.stretch_ppm.reset();
  const ProgramRun unasked = run_program(metric(kBody), options, source);
  EXPECT_TRUE(unasked.survey.is_accepted());
  EXPECT_FALSE(unasked.survey.series[0].fault);

  options.base_limits.residual = um(20);
  FunctionSource again = with_a_liar();
  const ProgramRun refused = run_program(metric(kBody), options, again);
  EXPECT_FALSE(refused.survey.is_accepted());
  EXPECT_TRUE(refused.survey.series[0].fault);
  EXPECT_EQ(refused.diagnostics.size(), 1U);  // gate-failed alone
}

/// The hole at (192, 151.5) was taken for the third target.
TEST(SeriesExamination, NamesAPadOfTheProgram) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    const Vector2d off(0.3, 0);
    return request.line == kThirdLine ? Vector2d(192.3, 151.5) : request.nominal.in_mm() + off;
  });
  const ProgramRun nominal = run_program(metric(kBody), examining());
  PadCollector collector(nominal.survey);
  DiagnosticLog log;
  execute(nominal.program, examining(), nominal.survey, collector, log);
  const KnownPads pads = collector.take();
  EXPECT_EQ(pads.all().size(), 6U);
  WalkOptions options = examining();
  int n_asked = 0;
  options.known_pads = [&] {
    ++n_asked;
    return &pads;
  };
  const ProgramRun run = run_program(metric(kBody), options, source);
  EXPECT_THAT(run.texts, testing::Contains(says(kThirdLine, "(192.0000, 151.5000) mm (line 12)")));
  EXPECT_EQ(n_asked, 1);
}

TEST(SeriesExamination, DoesNotLeaveOutWhatNothingChecksAfterwards) {
  std::vector<FitPoint> points(3);
  points[1].nominal = position_mm<frame::Nominal>(100, 0);
  points[2].nominal = position_mm<frame::Nominal>(0, 100);
  for (FitPoint& point : points) {
    point.measured = {position_mm<frame::Actual>(point.nominal.in_mm()),
                      1e-6 * Eigen::Matrix2d::Identity()};
  }
  EXPECT_FALSE(without_point(points, 0, PanelModel::Stretch));
  EXPECT_FALSE(without_point(points, 0, PanelModel::Similarity));
  EXPECT_TRUE(without_point(points, 0, PanelModel::Rigid));
}

}  // namespace
}  // namespace panelcal
