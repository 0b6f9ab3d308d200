// SPDX-License-Identifier: Apache-2.0
#include "tools/report/input/budget.h"

#include <gmock/gmock.h>

namespace panelcal::report {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kUm2 = 1e-6;  // in mm^2

Drill hole(double x_mm, double variance_mm2) {
  Drill drill;
  drill.nominal = position_mm<frame::Nominal>(x_mm, 2.);
  drill.cov_mm2 = variance_mm2 * Eigen::Matrix2d::Identity();
  drill.tool = 3;
  return drill;
}

/// A survey of one hole that was measured and drilled at its own target.
Survey one_target() {
  Survey survey;
  survey.measurements.resize(1);
  survey.measurements[0].measured.cov = 9 * kUm2 * Eigen::Matrix2d::Identity();
  return survey;
}

TEST(WorstHole, IsTheLeastCertainOneAndTheFirstOfEquals) {
  WorstHole worst;
  EXPECT_FALSE(worst.budget({}, {}));
  Origin origin;
  origin.i_measurement = 0;
  const std::vector<int> path = {0, 2};
  worst.put({11, {}, hole(1, 0), {}, &origin});
  EXPECT_FALSE(worst.budget(one_target(), {}));
  worst.put({12, {}, hole(2, 8 * kUm2), {}, &origin});
  worst.put({13, path, hole(3, 9 * kUm2), {}, &origin});
  worst.put({14, {}, hole(4, 9 * kUm2), {}, &origin});
  const auto found = worst.budget(one_target(), {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->line, 13);
  EXPECT_EQ(found->path, path);
  EXPECT_EQ(found->nominal, position_mm<frame::Nominal>(3., 2.));
  EXPECT_EQ(total_mm2(found->budget)(0, 0), 9 * kUm2);
}

/// The place of the verdict, though another one is less certain.
TEST(LikeliestToBreak, IsThePlaceThatTheVerdictNames) {
  Tolerances tolerances;
  tolerances.position = um(10);
  JobVerdict verdict(tolerances);
  EXPECT_FALSE(likeliest_to_break(verdict, {}, {}));
  Origin origin;
  origin.i_measurement = 0;
  const std::vector<int> path = {0, 2};
  Drill sure_of_much = hole(1, 16 * kUm2);
  sure_of_much.risk = sure_of_much.judged_risk = 1e-9;
  Drill worst = hole(2, 9 * kUm2);
  worst.risk = worst.judged_risk = 0.25;
  worst.tool = 4;
  verdict.put({11, {}, sure_of_much, {}, &origin});
  verdict.put({12, path, worst, "PINS", &origin});
  const auto found = likeliest_to_break(verdict, one_target(), {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->line, 12);
  EXPECT_EQ(found->file, "PINS");
  EXPECT_EQ(found->path, path);
  EXPECT_EQ(found->tool, 4);
  EXPECT_EQ(total_mm2(found->budget)(0, 0), 9 * kUm2);
  EXPECT_THAT(budget_section(found),
              HasSubstr("The place likeliest to break its tolerance, with a risk of 0.25: line 12 "
                        "of PINS, board [0,2], T4, nominal (2.000, 2.000) mm"));
}

TEST(BudgetSection, SaysWhereItComesFromAndWhatAllHolesShare) {
  MachineUncertainty machine;
  machine.spindle_camera_mm2 = 16 * kUm2 * Eigen::Matrix2d::Identity();
  HoleBudget hole{.line = 13,
                  .file = "A<B",
                  .path = {0, 2},
                  .tool = 3,
                  .nominal = position_mm<frame::Nominal>(1., 2.),
                  .risk = std::nullopt,
                  .budget = error_budget_at_target(
                      machine, 9 * kUm2 * Eigen::Matrix2d::Identity(), CameraJacobian::Zero(), 0)};
  const std::string section = budget_section(hole);
  EXPECT_THAT(section, HasSubstr("line 13 of A&lt;B, board [0,2], T3, nominal (1.000, 2.000) mm"));
  EXPECT_THAT(section, HasSubstr("detector</td><td class=\"num\">3.00</td>"));
  EXPECT_THAT(section, HasSubstr("<td class=\"num\">36.0 %</td>"));
  EXPECT_THAT(section, HasSubstr("<td class=\"num\">64.0 %</td>"));
  EXPECT_THAT(section, HasSubstr("total</td><td class=\"num\">5.00</td>"));
  EXPECT_THAT(section, HasSubstr("here 4.00 &#181;m in x and 4.00 &#181;m in y"));
  EXPECT_THAT(section, HasSubstr("not counted: camera calibration, stage at the targets"));
}

TEST(BudgetSection, IsLeftOutWithoutAnyCorrection) {
  EXPECT_EQ(budget_section(std::nullopt), "");
}

}  // namespace
}  // namespace panelcal::report
