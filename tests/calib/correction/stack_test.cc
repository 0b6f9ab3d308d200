// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/stack.h"

#include "calib/camera/mapping.h"
#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::chi_square_agrees;
using test::Coefficients;
using test::IsNearMatrix;
using test::IsNearPosition;
using test::mean_agrees;

using BasePair = TargetPair<frame::Base, frame::Nominal>;
using NestedPair = TargetPair<frame::Actual, frame::Base>;

constexpr double kSigma_mm = 0.010;
/// Rounding of coordinates of 500 mm.
constexpr Length kRounding = mm(1e-11);

/// Two-stage truth: a panel of 500 x 400 mm, a pattern of 60 x 40 mm on it that moved by itself.
struct Panel {
  std::vector<Eigen::Vector2d> base_targets_mm = {{0, 0}, {500, 0}, {0, 400}};
  std::vector<Eigen::Vector2d> nested_targets_mm = {{300, 100}, {360, 100}, {300, 140}};
  Eigen::Vector2d hole_mm = {341, 127};
  Coefficients base;    ///< of what base targets follow
  Coefficients nested;  ///< of what nested targets and holes follow, on top of base
};

/// n_nested = 1, 2 or 3: the nested series' size; its truth lies within its model.
Panel make_panel(int n_nested) {
  Panel panel;
  panel.nested_targets_mm.resize(static_cast<std::size_t>(n_nested));
  internal::ModelParameters base(5);
  base << 0.011, 1.0004, 0.9995, 1.7, -2.3;
  panel.base = internal::coefficients(PanelModel::Stretch, base);
  internal::ModelParameters nested(5);
  nested << (n_nested > 1 ? -0.002 : 0), (n_nested > 2 ? 1.0008 : 1), (n_nested > 2 ? 0.9994 : 1),
      0.08, -0.05;
  panel.nested = internal::coefficients(PanelModel::Stretch, nested);
  return panel;
}

/// Seen places, in mm: base targets, then nested ones, x and y alternating.
using Seen = Eigen::VectorXd;

Seen exactly_seen(const Panel& panel) {
  const auto n_base = static_cast<Eigen::Index>(panel.base_targets_mm.size());
  const auto n_nested = static_cast<Eigen::Index>(panel.nested_targets_mm.size());
  Seen seen(2 * (n_base + n_nested));
  Eigen::Index at = 0;
  for (const Eigen::Vector2d& p_mm : panel.base_targets_mm) {
    seen.segment<2>(at) = test::mapped(panel.base, p_mm);
    at += 2;
  }
  for (const Eigen::Vector2d& p_mm : panel.nested_targets_mm) {
    seen.segment<2>(at) = test::mapped(panel.nested, test::mapped(panel.base, p_mm));
    at += 2;
  }
  return seen;
}

/// The whole estimate: both series fitted one after the other and installed.
CorrectionStack estimate(const Panel& panel,
                         const Seen& seen,
                         const std::vector<Eigen::Matrix2d>& covs) {
  CorrectionStack stack;
  std::vector<BasePair> base_pairs;
  std::size_t i_seen = 0;
  const auto next = [&]<class F>(F) {
    const auto i = static_cast<Eigen::Index>(i_seen);
    PositionEstimate<F> out = {position_mm<F>(seen.segment<2>(2 * i).eval()), covs[i_seen]};
    ++i_seen;
    return out;
  };
  for (const Eigen::Vector2d& p_mm : panel.base_targets_mm) {
    base_pairs.push_back({position_mm<frame::Nominal>(p_mm), next(frame::Base())});
  }
  auto base = fit_panel(std::span<const BasePair>(base_pairs), PanelModel::Stretch);
  stack.set_base(std::make_shared<BaseFit>(*std::move(base.fit)));

  std::vector<NestedPair> nested_pairs;
  for (const Eigen::Vector2d& p_mm : panel.nested_targets_mm) {
    nested_pairs.push_back(
        {stack.base_from_nominal()(position_mm<frame::Nominal>(p_mm)), next(frame::Actual())});
  }
  if (nested_pairs.empty()) return stack;
  const PanelModel model = default_model(static_cast<int>(nested_pairs.size()));
  auto nested = fit_panel(std::span<const NestedPair>(nested_pairs), model);
  stack.set_nested(std::make_shared<NestedFit>(*std::move(nested.fit)));
  return stack;
}

std::vector<Eigen::Matrix2d> random_covariances(Random& random, const Panel& panel) {
  std::vector<Eigen::Matrix2d> covs;
  const std::size_t n = panel.base_targets_mm.size() + panel.nested_targets_mm.size();
  for (std::size_t i = 0; i < n; ++i) covs.push_back(test::random_covariance(random, kSigma_mm));
  return covs;
}

Coefficients coefficients_of(const Transform<frame::Actual, frame::Nominal>& t) {
  Coefficients a;
  a << t.linear()(0, 0), t.linear()(0, 1), t.linear()(1, 0), t.linear()(1, 1), t.translation();
  return a;
}

TEST(CorrectionStack, IsTheIdentityWithoutCorrections) {
  const CorrectionStack stack;
  const auto p = stack.actual_from_nominal()(position_mm<frame::Nominal>(3, 4));
  EXPECT_EQ(p.position, position_mm<frame::Actual>(3, 4));
  EXPECT_EQ(p.cov, Eigen::Matrix2d::Zero());
  EXPECT_EQ(stack.base(), nullptr);
  EXPECT_EQ(stack.nested(), nullptr);
}

TEST(CorrectionStack, AppliesNestedAfterBase) {
  const Panel panel = make_panel(3);
  Random random(31);
  const CorrectionStack stack =
      estimate(panel, exactly_seen(panel), random_covariances(random, panel));
  const Eigen::Vector2d true_mm =
      test::mapped(panel.nested, test::mapped(panel.base, panel.hole_mm));
  EXPECT_THAT(stack.actual_from_nominal()(position_mm<frame::Nominal>(panel.hole_mm)).position,
              IsNearPosition(position_mm<frame::Actual>(true_mm), kRounding));
}

TEST(CorrectionStack, NewBaseDropsNested) {
  // CNC-7 manual, G35 to G37, G45 to G47.
  const Panel panel = make_panel(2);
  Random random(32);
  CorrectionStack stack = estimate(panel, exactly_seen(panel), random_covariances(random, panel));
  ASSERT_NE(stack.nested(), nullptr);
  const auto base = std::make_shared<BaseFit>(*stack.base());
  stack.set_base(base);
  EXPECT_EQ(stack.base(), base.get());
  EXPECT_EQ(stack.nested(), nullptr);
  EXPECT_EQ(stack.actual_from_nominal().map.linear(), base->map.map.linear());
  EXPECT_THAT(stack.actual_from_nominal().cov, IsNearMatrix(base->map.cov, 1e-18));
}

TEST(CorrectionStack, ClearsNestedAloneOrBoth) {
  const Panel panel = make_panel(1);
  Random random(33);
  CorrectionStack stack = estimate(panel, exactly_seen(panel), random_covariances(random, panel));
  stack.clear_nested();
  EXPECT_NE(stack.base(), nullptr);
  EXPECT_EQ(stack.nested(), nullptr);
  EXPECT_EQ(stack.actual_from_nominal().map.linear(), stack.base()->map.map.linear());

  stack = estimate(panel, exactly_seen(panel), random_covariances(random, panel));
  stack.clear_base();
  EXPECT_EQ(stack.base(), nullptr);
  EXPECT_EQ(stack.nested(), nullptr);
  EXPECT_EQ(stack.base_from_nominal(), (Transform<frame::Base, frame::Nominal>()));
  EXPECT_EQ(stack.actual_from_nominal().cov, (Eigen::Matrix<double, 6, 6>::Zero()));
}

TEST(CorrectionStack, NestedWithoutBaseIsTheNestedFit) {
  Random random(34);
  std::vector<NestedPair> pairs;
  for (const Eigen::Vector2d& p_mm : {Eigen::Vector2d(0, 0), Eigen::Vector2d(50, 0)}) {
    pairs.push_back({position_mm<frame::Base>(p_mm),
                     {position_mm<frame::Actual>(p_mm + Eigen::Vector2d(0.1, 0.2)),
                      test::random_covariance(random, kSigma_mm)}});
  }
  auto fit = fit_panel(std::span<const NestedPair>(pairs), PanelModel::Rigid);
  const auto nested = std::make_shared<NestedFit>(*std::move(fit.fit));
  CorrectionStack stack;
  stack.set_nested(nested);
  EXPECT_EQ(stack.actual_from_nominal().map.translation(), nested->map.map.translation());
  EXPECT_THAT(stack.actual_from_nominal().cov, IsNearMatrix(nested->map.cov, 1e-18));
}

class NestedSeries : public testing::TestWithParam<int> {};

TEST_P(NestedSeries, CovarianceIsThatOfTheWholeEstimate) {
  // Brute force: both fits again for every measurement moved a little.
  const Panel panel = make_panel(GetParam());
  Random random(40 + static_cast<std::uint64_t>(GetParam()));
  const std::vector<Eigen::Matrix2d> covs = random_covariances(random, panel);
  const Seen seen = exactly_seen(panel);
  const CorrectionStack stack = estimate(panel, seen, covs);
  constexpr double kStep_mm = 1e-3;
  Eigen::Matrix<double, 6, 6> brute = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < covs.size(); ++i) {
    Eigen::Matrix<double, 6, 2> derivative;
    for (int axis = 0; axis < 2; ++axis) {
      Seen moved = seen;
      const Eigen::Index k = 2 * static_cast<Eigen::Index>(i) + axis;
      moved[k] = seen[k] + kStep_mm;
      const Coefficients above =
          coefficients_of(estimate(panel, moved, covs).actual_from_nominal().map);
      moved[k] = seen[k] - kStep_mm;
      const Coefficients below =
          coefficients_of(estimate(panel, moved, covs).actual_from_nominal().map);
      derivative.col(axis) = (above - below) / (2 * kStep_mm);
    }
    brute += derivative * covs[i] * derivative.transpose();
  }
  // Compared at the hole and element by element, each in its own size.
  const Eigen::Matrix<double, 6, 6>& cov = stack.actual_from_nominal().cov;
  double worst = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const double size = std::sqrt(brute(i, i) * brute(j, j));
      worst = std::max(worst, std::abs(cov(i, j) - brute(i, j)) / size);
    }
  }
  RecordProperty("worst_relative", testing::PrintToString(worst));
  // Steps of 1e-3 over 40 mm leave 1e-9 of curvature; differences of 1e-13 over 1e-3 as much.
  EXPECT_LE(worst, 1e-6);
}

TEST_P(NestedSeries, HolesErrAsPredicted) {
  constexpr int kTrials = 2000;
  const Panel panel = make_panel(GetParam());
  Random random(50 + static_cast<std::uint64_t>(GetParam()));
  const std::vector<Eigen::Matrix2d> covs = random_covariances(random, panel);
  const Seen exact = exactly_seen(panel);
  const Eigen::Vector2d true_mm =
      test::mapped(panel.nested, test::mapped(panel.base, panel.hole_mm));
  double chi_square = 0;
  Eigen::Vector2d error_sum_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    Seen seen = exact;
    for (std::size_t i = 0; i < covs.size(); ++i) {
      seen.segment<2>(2 * static_cast<Eigen::Index>(i)) += test::draw(random, covs[i]);
    }
    const CorrectionStack stack = estimate(panel, seen, covs);
    const auto hole = stack.actual_from_nominal()(position_mm<frame::Nominal>(panel.hole_mm));
    const Eigen::Vector2d error_mm = hole.position.in_mm() - true_mm;
    chi_square += error_mm.dot(hole.cov.llt().solve(error_mm));
    error_sum_mm += error_mm;
    cov_mm2 = hole.cov;
  }
  RecordProperty("chi_square_per_dof", testing::PrintToString(chi_square / (2 * kTrials)));
  EXPECT_TRUE(chi_square_agrees(chi_square, 2 * kTrials));
  for (int axis = 0; axis < 2; ++axis) {
    const double sigma_mm = std::sqrt(cov_mm2(axis, axis));
    EXPECT_TRUE(mean_agrees(error_sum_mm[axis] / kTrials, 0, sigma_mm, kTrials));
  }
}

TEST_P(NestedSeries, TakesUpWhatTheBaseGotWrong) {
  // At the nested targets' centroid an error of the base is measured away entirely.
  const Panel panel = make_panel(GetParam());
  Random random(60);
  std::vector<Eigen::Matrix2d> covs = random_covariances(random, panel);
  const auto sigma_at_centroid = [&] {
    const CorrectionStack stack = estimate(panel, exactly_seen(panel), covs);
    Eigen::Vector2d centroid_mm = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p_mm : panel.nested_targets_mm) centroid_mm += p_mm;
    centroid_mm /= static_cast<double>(panel.nested_targets_mm.size());
    return std::sqrt(
        stack.actual_from_nominal()(position_mm<frame::Nominal>(centroid_mm)).cov(0, 0));
  };
  for (std::size_t i = 3; i < covs.size(); ++i) covs[i] = covs[3];
  const double before_mm = sigma_at_centroid();
  for (std::size_t i = 0; i < 3; ++i) covs[i] *= 1e4;
  EXPECT_NEAR(sigma_at_centroid(), before_mm, 1e-3 * before_mm);
}

TEST_P(NestedSeries, CountsTheCameraOnceForBothFits) {
  // Brute force: both fits again with one parameter of the calibration moved for all pictures.
  const Panel panel = make_panel(GetParam());
  Random random(80 + static_cast<std::uint64_t>(GetParam()));
  const std::vector<Eigen::Matrix2d> covs = random_covariances(random, panel);
  const CameraMapping camera({0.01, 0.004, {323, 236}, 4e-8});
  std::vector<CameraJacobian> by_camera;
  for (std::size_t i = 0; i < covs.size(); ++i) {
    by_camera.push_back(
        camera.by_parameters(position_px(random.uniform(200, 440), random.uniform(140, 340))));
  }
  MachineUncertainty machine;
  const Eigen::Vector<double, 5> sigma(2e-6, 5e-4, 0.3, 0.2, 1e-8);
  machine.camera =
      (sigma * sigma.transpose())
          .cwiseProduct(0.6 * CameraCovariance::Identity() + 0.4 * CameraCovariance::Ones());

  const Seen seen = exactly_seen(panel);
  CorrectionStack stack(machine);
  const CorrectionStack plain = estimate(panel, seen, covs);
  BaseFit base = *plain.base();
  NestedFit nested = *plain.nested();
  for (std::size_t i = 0; i < base.pairs.size(); ++i) base.pairs[i].by_camera = by_camera[i];
  for (std::size_t i = 0; i < nested.pairs.size(); ++i) {
    nested.pairs[i].by_camera = by_camera[base.pairs.size() + i];
  }
  stack.set_base(std::make_shared<const BaseFit>(base));
  stack.set_nested(std::make_shared<const NestedFit>(nested));

  Eigen::Matrix<double, 6, 5> whole_by_camera;
  for (int k = 0; k < 5; ++k) {
    const auto moved = [&](double step) {
      Seen out = seen;
      for (std::size_t i = 0; i < covs.size(); ++i) {
        out.segment<2>(2 * static_cast<Eigen::Index>(i)) += step * sigma[k] * by_camera[i].col(k);
      }
      return coefficients_of(estimate(panel, out, covs).actual_from_nominal().map);
    };
    whole_by_camera.col(k) = (moved(1) - moved(-1)) / (2 * sigma[k]);
  }
  const auto at_hole = [&](const Eigen::Matrix<double, 6, 6>& cov) {
    TransformEstimate<frame::Actual, frame::Nominal> map;
    map.cov = cov;
    return map(position_mm<frame::Nominal>(panel.hole_mm)).cov;
  };
  const Eigen::Matrix2d brute =
      at_hole(whole_by_camera * machine.camera * whole_by_camera.transpose());
  const Eigen::Matrix2d added =
      at_hole(stack.actual_from_nominal().cov - plain.actual_from_nominal().cov);
  EXPECT_THAT(added, IsNearMatrix(brute, 1e-5 * brute.trace()));
  EXPECT_GT(brute.trace(), 1e-6);  // over a micrometre: not a comparison of zeros
}

TEST_P(NestedSeries, AnErrorOfTheOpticalAxisMovesEveryHoleAlike) {
  // 0.2 px of 10 um in x, the same in all pictures: no number of targets makes it smaller.
  const Panel panel = make_panel(GetParam());
  Random random(90);
  const CorrectionStack plain =
      estimate(panel, exactly_seen(panel), random_covariances(random, panel));
  const CameraMapping camera({0.01, 0, {320, 240}, 0});
  BaseFit base = *plain.base();
  NestedFit nested = *plain.nested();
  for (auto& pair : base.pairs) pair.by_camera = camera.by_parameters(position_px(320., 240.));
  for (auto& pair : nested.pairs) pair.by_camera = camera.by_parameters(position_px(320., 240.));
  MachineUncertainty machine;
  machine.camera(2, 2) = 0.04;
  CorrectionStack stack(machine);
  stack.set_base(std::make_shared<const BaseFit>(base));
  stack.set_nested(std::make_shared<const NestedFit>(nested));
  for (const auto& [x, y] : {std::pair(341., 127.), {-300., 700.}}) {
    const auto hole = position_mm<frame::Nominal>(x, y);
    const Eigen::Matrix2d added =
        stack.actual_from_nominal()(hole).cov - plain.actual_from_nominal()(hole).cov;
    Eigen::Matrix2d expected = Eigen::Matrix2d::Zero();
    expected(0, 0) = 4e-6;
    EXPECT_THAT(added, IsNearMatrix(expected, 1e-12));
  }
}

INSTANTIATE_TEST_SUITE_P(OfOneTwoAndThree, NestedSeries, testing::Values(1, 2, 3));

}  // namespace
}  // namespace panelcal
