// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/error_budget.h"

#include <cmath>
#include <limits>
#include <memory>

#include "calib/base/statistics/random.h"
#include "calib/camera/mapping.h"
#include "calib/correction/max_sigma.h"
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;
using BasePair = TargetPair<frame::Base, frame::Nominal>;
using NestedPair = TargetPair<frame::Actual, frame::Base>;

constexpr double kUm2 = 1e-6;  // in mm^2
const Eigen::Matrix2d kOne = Eigen::Matrix2d::Identity();

CameraMapping camera() {
  return CameraMapping({0.01, 0.004, {323, 236}, 4e-8});
}

MachineUncertainty machine() {
  MachineUncertainty m;
  m.stage_repeatability = um(1.5);
  m.table_residual = um(2.5);
  m.table_map = um(0.9);
  m.drill_wander = um(3);
  m.spindle_camera_mm2 = 0.8 * kUm2 * kOne;
  m.drift_mm2 = 0.3 * kUm2 * kOne;
  m.camera.diagonal() << 4e-14, 1e-10, 1e-2, 4e-2, 1e-20;
  m.camera(2, 3) = m.camera(3, 2) = 0.5e-2;
  m.zooms[2] = 9 * m.camera;
  return m;
}

/// Jacobian of a target's place in its picture: they differ, as on a panel that is askew.
CameraJacobian seen_at(Random& random) {
  return camera().by_parameters(position_px(random.uniform(250, 390), random.uniform(170, 310)));
}

std::shared_ptr<const BaseFit> base_fit(Random& random, const MachineUncertainty& m) {
  std::vector<BasePair> pairs;
  for (const auto& [x, y] : {std::pair(0., 0.), {400., 10.}, {20., 300.}, {410., 290.}}) {
    const Eigen::Matrix2d cov = test::random_covariance(random, 2e-3) + m.of_target_mm2();
    pairs.push_back({position_mm<frame::Nominal>(x, y),
                     {position_mm<frame::Base>(x * 1.0002 - 0.01 * y + 1, y + 0.01 * x), cov},
                     ObservedAxes::Both,
                     seen_at(random)});
  }
  return std::make_shared<const BaseFit>(
      *fit_panel(std::span<const BasePair>(pairs), PanelModel::Stretch).fit);
}

std::shared_ptr<const NestedFit> nested_fit(Random& random,
                                            const MachineUncertainty& m,
                                            const CorrectionStack& stack) {
  std::vector<NestedPair> pairs;
  for (const auto& [x, y] : {std::pair(100., 100.), {160., 104.}, {103., 150.}}) {
    const auto expected = stack.base_from_nominal()(position_mm<frame::Nominal>(x, y));
    const Eigen::Vector2d seen_mm = expected.in_mm() + Eigen::Vector2d(0.05 - 1e-3 * y, 1e-3 * x);
    pairs.push_back({expected,
                     {position_mm<frame::Actual>(seen_mm),
                      test::random_covariance(random, 2e-3) + m.of_target_mm2()},
                     ObservedAxes::Both,
                     seen_at(random),
                     1});
  }
  return std::make_shared<const NestedFit>(
      *fit_panel(std::span<const NestedPair>(pairs), PanelModel::Rigid).fit);
}

Eigen::Matrix2d term(const ErrorBudget& budget, std::string_view source) {
  for (const BudgetTerm& one : budget) {
    if (one.source == source) return one.cov_mm2;
  }
  ADD_FAILURE() << "no term " << source;
  return {};
}

TEST(ErrorBudget, AddsUpToTheCovarianceOfWhatIsDrilled) {
  Random random(71);
  const MachineUncertainty m = machine();
  CorrectionStack stack(m);
  for (const bool has_nested : {false, true}) {
    stack.set_base(base_fit(random, m));
    if (has_nested) stack.set_nested(nested_fit(random, m, stack));
    for (const auto& [x, y] : {std::pair(0., 0.), {130., 120.}, {-200., 500.}}) {
      const auto hole = position_mm<frame::Nominal>(x, y);
      const ErrorBudget budget = error_budget(stack, hole);
      const Eigen::Matrix2d whole_mm2 = stack.drilled_from_nominal()(hole).cov;
      EXPECT_THAT(total_mm2(budget), IsNearMatrix(whole_mm2, 1e-12 * whole_mm2.trace()));
      for (const BudgetTerm& one : budget) EXPECT_GT(one.cov_mm2.trace(), 0) << one.source;
    }
  }
}

TEST(ErrorBudget, CountsATermThatIsStatedAsZero) {
  Random random(73);
  for (const bool states : {false, true}) {
    MachineUncertainty m;
    m.states_stage = m.states_table = m.states_wander = states;
    CorrectionStack stack(m);
    stack.set_base(base_fit(random, m));
    for (const BudgetTerm& one : error_budget(stack, position_mm<frame::Nominal>(130, 120))) {
      const bool is_of_machine = one.source.starts_with("stage") ||
                                 one.source.starts_with("table") || one.source == "drill wander";
      if (is_of_machine) {
        EXPECT_EQ(one.counts(), states) << one.source;
      }
    }
  }
}

TEST(ErrorBudget, NamesWhatAMisfitAdds) {
  Random random(72);
  const MachineUncertainty m = machine();
  CorrectionStack stack(m);
  BaseFit base = *base_fit(random, m);
  base.misfit_cov = 15 * base.map.cov;
  base.map.cov += base.misfit_cov;
  stack.set_base(std::make_shared<const BaseFit>(base));
  const auto hole = position_mm<frame::Nominal>(130, 120);
  const Eigen::Matrix2d alone_mm2 = term(error_budget(stack, hole), "misfit of the targets");
  EXPECT_THAT(alone_mm2, IsNearMatrix(place_cov_mm2(base.misfit_cov, hole), 1e-15));

  NestedFit nested = *nested_fit(random, m, stack);
  nested.misfit_cov = 3 * nested.map.cov;
  nested.map.cov += nested.misfit_cov;
  stack.set_nested(std::make_shared<const NestedFit>(nested));
  const ErrorBudget budget = error_budget(stack, hole);
  const Eigen::Matrix2d whole_mm2 = stack.drilled_from_nominal()(hole).cov;
  EXPECT_THAT(total_mm2(budget), IsNearMatrix(whole_mm2, 1e-12 * whole_mm2.trace()));
  // The nested fit takes the base's error back.
  EXPECT_LT(term(budget, "misfit of the targets").trace(), alone_mm2.trace());
}

TEST(ErrorBudget, OfAnOffsetByTwoTargetsIsWhatOneWorksOutByHand) {
  // Detector 2 um, stage 4 um, table 6 um and its map 2 um at two targets: their mean has half the
  // variances.
  MachineUncertainty m;
  m.stage_repeatability = um(4);
  m.table_residual = um(6);
  m.table_map = um(2);
  m.drill_wander = um(1);
  m.spindle_camera_mm2 = 9 * kUm2 * kOne;
  m.drift_mm2 = 25 * kUm2 * kOne;
  std::vector<BasePair> pairs;
  for (const double x : {0., 100.}) {
    pairs.push_back({position_mm<frame::Nominal>(x, 0.),
                     {position_mm<frame::Base>(x + 1, 2.), 4 * kUm2 * kOne + m.of_target_mm2()}});
  }
  CorrectionStack stack(m);
  stack.set_base(std::make_shared<const BaseFit>(
      *fit_panel(std::span<const BasePair>(pairs), PanelModel::Offset).fit));
  const ErrorBudget budget = error_budget(stack, position_mm<frame::Nominal>(300., 400.));
  const auto expect = [&](std::string_view source, double um2) {
    EXPECT_THAT(term(budget, source), IsNearMatrix(um2 * kUm2 * kOne, 1e-15)) << source;
  };
  expect("detector", 2);
  expect("stage at the targets", 8);
  expect("table at the targets", 18);
  expect("camera calibration", 0);
  expect("spindle-camera offset", 9);
  expect("its drift", 25);
  expect("stage at the hole", 16);
  expect("table at the hole", 36);
  expect("drill wander", 1);
  expect("table map at the targets", 2);
  expect("table map at the hole", 4);
  EXPECT_THAT(total_mm2(budget), IsNearMatrix(121 * kUm2 * kOne, 1e-15));
}

/// Only what pictures say, as the budget has it at each place, whatever the machine adds.
TEST(PictureCovariance, IsTheBudgetsDetectorTerm) {
  Random random(73);
  const MachineUncertainty m = machine();
  CorrectionStack stack(m);
  EXPECT_EQ(coefficients_cov_of_pictures(stack), (Eigen::Matrix<double, 6, 6>::Zero()));
  for (const bool has_nested : {false, true}) {
    stack.set_base(base_fit(random, m));
    if (has_nested) stack.set_nested(nested_fit(random, m, stack));
    const Eigen::Matrix<double, 6, 6> cov = coefficients_cov_of_pictures(stack);
    for (const auto& [x, y] : {std::pair(0., 0.), {130., 120.}, {-200., 500.}}) {
      const auto hole = position_mm<frame::Nominal>(x, y);
      const Eigen::Matrix2d detector_mm2 = term(error_budget(stack, hole), "detector");
      EXPECT_GT(detector_mm2.trace(), 0);
      EXPECT_THAT(place_cov_mm2(cov, hole),
                  IsNearMatrix(detector_mm2, 1e-12 * detector_mm2.trace()));
    }
  }
}

TEST(ErrorBudget, NothingIsKnownWithoutACorrection) {
  const CorrectionStack stack(machine());
  EXPECT_TRUE(error_budget(stack, position_mm<frame::Nominal>(1., 2.)).empty());
  EXPECT_EQ(stack.drilled_from_nominal()(position_mm<frame::Nominal>(1., 2.)).cov,
            Eigen::Matrix2d::Zero());
}

TEST(ErrorBudget, AHoleAtItsOwnTargetHasAllTermsOnce) {
  const MachineUncertainty m = machine();
  Random random(72);
  const CameraJacobian by_camera = seen_at(random);
  const Eigen::Matrix2d seen_mm2 = test::random_covariance(random, 2e-3);
  const Eigen::Matrix2d expected_mm2 = seen_mm2 + 9 * by_camera * m.camera * by_camera.transpose() +
                                       m.of_target_mm2() + m.shared_mm2() + m.of_hole_mm2();
  EXPECT_THAT(total_mm2(error_budget_at_target(m, seen_mm2, by_camera, m.camera_index(2.0))),
              IsNearMatrix(expected_mm2, 1e-15));
}

TEST(ErrorBudget, LargestSigmaIsAlongTheEllipse) {
  const Eigen::Matrix2d turn = test::rotation(0.7);
  const Eigen::Matrix2d cov = turn * Eigen::Vector2d(25, 4).asDiagonal() * turn.transpose();
  EXPECT_NEAR(largest_sigma(cov).in_mm(), 5, 1e-12);
  EXPECT_EQ(largest_sigma(Eigen::Matrix2d::Zero()), Length());
}

/// Covariances of all sizes, many nearly as large as the largest so far.
TEST(MaxSigma, IsTheLargestOfAllAndTellsEachThatIsLarger) {
  Random random(20261123);
  for (int i = 0; i < 200; ++i) {
    MaxSigma max;
    Length largest;
    const double size_mm2 = std::pow(10, random.uniform(-320, 300));
    for (int k = 0; k < 200; ++k) {
      const double share = random.uniform() < 0.5 ? 1 + 1e-15 * random.uniform(-9, 9)
                                                  : std::pow(10, random.uniform(-6, 0));
      const Eigen::Matrix2d turn = test::rotation(random.uniform(0, 7));
      const Eigen::Vector2d variances(1, random.uniform() < 0.1 ? 0 : random.uniform());
      const Eigen::Matrix2d cov = random.uniform() < 0.05
                                      ? Eigen::Matrix2d::Zero()
                                      : Eigen::Matrix2d(size_mm2 * share * turn *
                                                        variances.asDiagonal() * turn.transpose());
      const bool is_larger = largest_sigma(cov) > largest;
      if (is_larger) largest = largest_sigma(cov);
      ASSERT_EQ(max.add(cov), is_larger) << "covariance " << k << " of round " << i;
      ASSERT_EQ(max.value(), largest);
    }
  }
}

TEST(MaxSigma, WhatIsNoNumberIsNotLarger) {
  MaxSigma max;
  const Eigen::Matrix2d none = Eigen::Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(max.add(none));
  EXPECT_TRUE(max.add(Eigen::Matrix2d::Identity()));
  EXPECT_FALSE(max.add(none));
  EXPECT_EQ(max.value(), mm(1));
}

TEST(MachineUncertainty, CountsCamerasByTheLevelOfTheirZoom) {
  MachineUncertainty m;
  EXPECT_EQ(m.n_cameras(), 1);
  m.zooms[3] = CameraCovariance::Identity();
  m.zooms[1] = 2 * CameraCovariance::Identity();
  EXPECT_EQ(m.n_cameras(), 3);
  EXPECT_EQ(m.camera_index(std::nullopt), 0);
  EXPECT_EQ(m.camera_index(1.0), 1);
  EXPECT_EQ(m.camera_index(3.0), 2);
  EXPECT_EQ(m.camera_index(2.0), 0);
  EXPECT_EQ(m.camera_of(1)(0, 0), 2);
  EXPECT_EQ(m.camera_of(0)(0, 0), 0);
}

}  // namespace
}  // namespace panelcal
