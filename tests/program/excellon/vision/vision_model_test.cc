// SPDX-License-Identifier: Apache-2.0
// [vision] model = "auto": the targets themselves say which model a series gets.
#include <string>

#include "calib/correction/error_budget.h"
#include "calib/panel/model_choice.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::run_program;

constexpr const char* kFour = "G36X0.Y0.\nG36X300.Y0.\nG36X300.Y200.\nG36X0.Y200.\nX150.Y100.\n";

WalkOptions automatic(int series_size) {
  WalkOptions options;
  options.series_size = series_size;
  options.chooses_model = true;
  return options;
}

ProgramRun run(std::string_view body, const Eigen::Matrix2d& linear, const WalkOptions& options) {
  FunctionSource source([&linear](const MeasurementRequest& request) -> Vector2d {
    return linear * request.nominal.in_mm() + Vector2d(0.4, -0.3);
  });
  ProgramRun out =
      run_program(metric("G34,1\nT1\n" + std::string(body) + "M30\n"), options, source);
  EXPECT_TRUE(out.diagnostics.empty()) << out.diagnostics.front();
  return out;
}

Eigen::Matrix2d turned(double angle_rad) {
  return Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
}

TEST(VisionModel, IsTheStiffestThatTheTargetsSpeakFor) {
  const auto model_of = [](const Eigen::Matrix2d& linear) {
    const ProgramRun found = run(kFour, linear, automatic(4));
    EXPECT_TRUE(found.survey.series.at(0).chose_model);
    EXPECT_EQ(found.survey.series.at(0).prescribed, PanelModel::Stretch);
    return found.survey.series.at(0).model;
  };
  EXPECT_EQ(model_of(Eigen::Matrix2d::Identity()), PanelModel::Offset);
  EXPECT_EQ(model_of(turned(0.003)), PanelModel::Rigid);
  EXPECT_EQ(model_of(1.001 * turned(0.003)), PanelModel::Similarity);
  EXPECT_EQ(model_of(turned(0.003) * Vector2d(1.001, 0.999).asDiagonal()), PanelModel::Stretch);
  EXPECT_EQ(model_of((Eigen::Matrix2d() << 1, 0.001, 0, 1).finished()), PanelModel::Affine);
}

/// "If two G36 codes are used, the pattern is adjusted for offset and rotation only."
TEST(VisionModel, StretchOfTheMachineIsOffsetAndRotationForTwoTargets) {
  WalkOptions options;
  options.series_size = 2;
  options.model = PanelModel::Stretch;
  const auto two = run("G36X0.Y0.\nG36X300.Y0.\nX150.Y0.\n", turned(0.003), options);
  EXPECT_EQ(two.survey.series.at(0).model, PanelModel::Rigid);
  const Vector2d hole_mm = turned(0.003) * Vector2d(150, 0) + Vector2d(0.4, -0.3);
  EXPECT_LT((two.holes().at(0).actual_mm() - hole_mm).norm(), 1e-9);
  options.series_size = 3;
  const auto three =
      run("G36X0.Y0.\nG36X300.Y0.\nG36X0.Y200.\nX150.Y100.\n", turned(0.003), options);
  EXPECT_EQ(three.survey.series.at(0).model, PanelModel::Stretch);
}

TEST(VisionModel, IsNoneThatTwoOrThreeTargetsCannotCheck) {
  const Eigen::Matrix2d sheared = (Eigen::Matrix2d() << 1, 0.001, 0, 1).finished();
  const ProgramRun three = run("G36X0.Y0.\nG36X300.Y0.\nG36X0.Y200.\n", sheared, automatic(3));
  EXPECT_LE(three.survey.series.at(0).model, PanelModel::Stretch);
  const ProgramRun two = run("G36X0.Y0.\nG36X300.Y0.\n", 1.001 * turned(0.003), automatic(2));
  EXPECT_EQ(two.survey.series.at(0).model, PanelModel::Rigid);
  const ProgramRun one = run("G35X0.Y0.\n", turned(0.003), automatic(2));
  EXPECT_EQ(one.survey.series.at(0).model, PanelModel::Offset);
}

TEST(VisionModel, IsComparedWhereSomebodyWantsToReadOfIt) {
  WalkOptions options = automatic(4);
  options.chooses_model = false;
  EXPECT_TRUE(run(kFour, turned(0.003), options).survey.series.at(0).compared.empty());
  options.compares_models = true;
  const ProgramRun found = run(kFour, turned(0.003), options);
  const SeriesResult& series = found.survey.series.at(0);
  EXPECT_EQ(series.model, PanelModel::Stretch);
  EXPECT_FALSE(series.chose_model);
  EXPECT_EQ(series.compared.size(), 5u);
  ASSERT_NE(chosen(series.compared), nullptr);
  EXPECT_EQ(chosen(series.compared)->model, PanelModel::Rigid);
  EXPECT_TRUE(series.base->choice_cov.isZero(0));
}

TEST(VisionModel, NestedOnesAreChosenToo) {
  const ProgramRun found =
      run(std::string(kFour) + "G46X20.Y20.\nG46X90.Y20.\nG46X90.Y80.\nG46X20.Y80.\nX50.Y50.\n",
          turned(0.003),
          automatic(4));
  ASSERT_EQ(found.survey.series.size(), 2u);
  EXPECT_EQ(found.survey.series[1].level, CorrectionLevel::Nested);
  EXPECT_EQ(found.survey.series[1].model, PanelModel::Offset);  // the base took the rotation
}

TEST(VisionModel, HolesAreLessSureWhereItWasChosen) {
  const ProgramRun by_targets = run(kFour, turned(0.003), automatic(4));
  WalkOptions options = automatic(4);
  options.chooses_model = false;
  options.model = PanelModel::Rigid;
  const ProgramRun by_decision = run(kFour, turned(0.003), options);
  const auto sigma_of = [](const ProgramRun& found) {
    CorrectionStack stack;
    stack.set_base(found.survey.series.at(0).base);
    const auto hole = position_mm<frame::Nominal>(0, 0);
    const Eigen::Matrix2d total = stack.drilled_from_nominal()(hole).cov;
    EXPECT_THAT(total_mm2(error_budget(stack, hole)),
                test::IsNearMatrix(total, 1e-9 * total.norm()));
    return total.norm();
  };
  EXPECT_GT(sigma_of(by_targets), 1.01 * sigma_of(by_decision));
}

}  // namespace
}  // namespace panelcal
