// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/truth_comparison.h"

#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

Truth shifted_panel() {
  Truth truth;
  truth.panel = Transform<frame::Actual, frame::Nominal>(Eigen::Matrix2d::Identity(),
                                                         Eigen::Vector2d(0.3, 0.4));
  truth.instances[{1}] =
      Transform<frame::Actual, frame::Nominal>(Eigen::Matrix2d::Identity(), Eigen::Vector2d(0, 0));
  return truth;
}

Drill hole(double x_mm, double corrected_x_mm) {
  return Drill{{position_mm<frame::Nominal>(x_mm, 0),
                position_mm<frame::Actual>(corrected_x_mm, 0),
                position_mm<frame::Machine>(corrected_x_mm, 0),
                1e-6 * Eigen::Matrix2d::Identity()},
               1};
}

TEST(TruthComparison, MeasuresErrorWithAndWithoutCorrection) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  comparison.put({1, {}, hole(10, 10.3)});
  EXPECT_NEAR(comparison.all().uncorrected.max().in_mm(), 0.5, 1e-12);
  EXPECT_NEAR(comparison.all().corrected.max().in_mm(), 0.4, 1e-12);
}

TEST(TruthComparison, TakesTheBoardOfTheHolesPath) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  comparison.put({1, path, hole(10, 10.003)});
  EXPECT_NEAR(comparison.all().corrected.max().in_um(), 3, 1e-9);
}

TEST(TruthComparison, NormalizesByThePredictedCovariance) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  comparison.put({1, path, hole(10, 10.002)});  // 2 sigma in one of two coordinates
  EXPECT_NEAR(comparison.mean_normalized_square(), 2, 1e-9);
}

TEST(TruthComparison, SumsUpAsTheTradeDoes) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  for (const double off_mm : {0.010, 0.014}) comparison.put({1, path, hole(10, 10 + off_mm)});
  const RadialFigures radial = comparison.by_tool().at(1).corrected.radial();
  EXPECT_NEAR(radial.mean().in_um(), 12, 1e-6);
  EXPECT_NEAR(radial.mean_plus_3_sigma().in_um(), 18, 1e-5);
}

TEST(TruthComparison, CountsByTool) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  for (int i = 0; i < 3; ++i) comparison.put({1, {}, hole(i, i)});
  EXPECT_EQ(comparison.by_tool().at(1).corrected.n, 3);
  EXPECT_NE(comparison.summary().find("T1"), std::string::npos);
}

}  // namespace
}  // namespace panelcal
