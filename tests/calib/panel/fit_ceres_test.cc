// SPDX-License-Identifier: Apache-2.0
// The fits against an independent solver: other parametrisation of the cost, other derivatives
// (automatic ones), other algebra.
#include "calib/panel/fit.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <ceres/ceres.h>
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::fit_raw;
using test::Coefficients;
using test::coefficients_of;
using test::IsNearMatrix;
using test::kAllModels;
using test::ModelParameters;
using test::RawFit;
using test::RawPair;

constexpr int kTrials = 40;
constexpr double kSigma_mm = 0.010;
/// Rounding of coordinates of 500 mm, several times over.
constexpr double kAgreement_mm = 1e-11;
/// Ceres iterates until the cost no longer falls, which leaves the root of its rounding.
constexpr double kAgreementOfIterations_mm = 1e-7;

/// In: parameters in the orders of panel_model.h; out: residuals in sigmas.
template <PanelModel kModel>
struct Residual {
  RawPair pair;
  Eigen::Matrix2d whitening;

  template <class T>
  bool operator()(const T* p, T* out) const {
    T to_mm[2];
    map_point(p, to_mm);
    const T dx = pair.to_mm.x() - to_mm[0];
    const T dy = pair.to_mm.y() - to_mm[1];
    out[0] = whitening(0, 0) * dx + whitening(0, 1) * dy;
    out[1] = whitening(1, 0) * dx + whitening(1, 1) * dy;
    return true;
  }

  template <class T>
  void map_point(const T* p, T* to_mm) const {
    const double x = pair.from_mm.x();
    const double y = pair.from_mm.y();
    if constexpr (kModel == PanelModel::Offset) {
      to_mm[0] = x + p[0];
      to_mm[1] = y + p[1];
    } else if constexpr (kModel == PanelModel::Rigid) {
      to_mm[0] = cos(p[0]) * x - sin(p[0]) * y + p[1];
      to_mm[1] = sin(p[0]) * x + cos(p[0]) * y + p[2];
    } else if constexpr (kModel == PanelModel::Similarity) {
      to_mm[0] = p[0] * x - p[1] * y + p[2];
      to_mm[1] = p[1] * x + p[0] * y + p[3];
    } else if constexpr (kModel == PanelModel::Stretch) {
      to_mm[0] = cos(p[0]) * p[1] * x - sin(p[0]) * p[2] * y + p[3];
      to_mm[1] = sin(p[0]) * p[1] * x + cos(p[0]) * p[2] * y + p[4];
    } else {
      to_mm[0] = p[0] * x + p[1] * y + p[4];
      to_mm[1] = p[2] * x + p[3] * y + p[5];
    }
  }
};

/// Divides what a target shows by its sigmas. A slot's other row is zero; nothing that is no number
/// may stand there.
template <PanelModel kModel>
Residual<kModel> residual_of(RawPair pair) {
  if (pair.axes == ObservedAxes::Both) {
    const Eigen::Matrix2d l = pair.cov_mm2.llt().matrixL();
    return {pair, l.inverse()};
  }
  const int axis = pair.axes == ObservedAxes::X ? 0 : 1;
  pair.to_mm[1 - axis] = 0;
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Zero();
  whitening(axis, axis) = 1 / std::sqrt(pair.cov_mm2(axis, axis));
  return {pair, whitening};
}

struct Judgement {
  Coefficients a;
  Eigen::Matrix<double, 6, 6> cov;
  double chi_square = 0;
};

template <PanelModel kModel, int kParameters>
Judgement solve(const std::vector<RawPair>& pairs) {
  ModelParameters p = ModelParameters::Zero(kParameters);
  if (kModel == PanelModel::Similarity) p[0] = 1;
  if (kModel == PanelModel::Stretch) p[1] = p[2] = 1;
  if (kModel == PanelModel::Affine) p[0] = p[3] = 1;
  ceres::Problem problem;
  for (const RawPair& pair : pairs) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Residual<kModel>, 2, kParameters>(
                                 new Residual<kModel>(residual_of<kModel>(pair))),
                             nullptr,
                             p.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 0;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 1e-16;
  options.max_num_iterations = 50;
  // No damping: its steps end short of the minimum by the root of rounding in the cost.
  options.initial_trust_region_radius = 1e16;
  options.max_trust_region_radius = 1e32;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(covariance_options);
  EXPECT_TRUE(covariance.Compute(std::vector<const double*>{p.data()}, &problem));
  Eigen::Matrix<double, kParameters, kParameters, Eigen::RowMajor> parameter_cov;
  EXPECT_TRUE(covariance.GetCovarianceBlock(p.data(), p.data(), parameter_cov.data()));
  const internal::ModelJacobian j = internal::coefficient_jacobian(kModel, p);
  return {
      internal::coefficients(kModel, p), j * parameter_cov * j.transpose(), 2 * summary.final_cost};
}

Judgement judge(const std::vector<RawPair>& pairs, PanelModel model) {
  switch (model) {
    case PanelModel::Offset:
      return solve<PanelModel::Offset, 2>(pairs);
    case PanelModel::Rigid:
      return solve<PanelModel::Rigid, 3>(pairs);
    case PanelModel::Similarity:
      return solve<PanelModel::Similarity, 4>(pairs);
    case PanelModel::Stretch:
      return solve<PanelModel::Stretch, 5>(pairs);
    case PanelModel::Affine:
      break;
  }
  return solve<PanelModel::Affine, 6>(pairs);
}

class PanelFitAgainstCeres : public testing::TestWithParam<PanelModel> {
 protected:
  Random random_{100 + static_cast<std::uint64_t>(parameter_count(GetParam()))};
};

TEST_P(PanelFitAgainstCeres, FindsTheSameMap) {
  double worst_mm = 0;
  double worst_chi_square = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    // The truth is affine, so that stiffer models have true residuals too, up to half a mm.
    const Coefficients truth = internal::coefficients(
        PanelModel::Affine, test::random_parameters(random_, PanelModel::Affine));
    const std::vector<RawPair> pairs =
        test::random_pairs(random_, 3 + trial % 6, truth, kSigma_mm, true);
    const internal::RawFitResult result = fit_raw(pairs, GetParam());
    ASSERT_TRUE(result.fit.has_value());
    const Judgement judgement = judge(pairs, GetParam());
    for (const RawPair& pair : pairs) {
      const Eigen::Vector2d ours_mm = test::mapped(coefficients_of(*result.fit), pair.from_mm);
      const Eigen::Vector2d theirs_mm = test::mapped(judgement.a, pair.from_mm);
      worst_mm = std::max(worst_mm, (ours_mm - theirs_mm).norm());
    }
    worst_chi_square = std::max(
        worst_chi_square,
        std::abs(result.fit->chi_square - judgement.chi_square) / (1 + judgement.chi_square));
  }
  RecordProperty("worst_mm", testing::PrintToString(worst_mm));
  RecordProperty("worst_chi_square", testing::PrintToString(worst_chi_square));
  EXPECT_LE(worst_mm, internal::is_linear(GetParam()) ? kAgreement_mm : kAgreementOfIterations_mm);
  EXPECT_LE(worst_chi_square, 1e-9);
}

TEST_P(PanelFitAgainstCeres, PredictsTheSameCovariance) {
  // From exact measurements: Ceres leaves out the model's curvature, which residuals bring in.
  double worst = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    const Coefficients truth =
        internal::coefficients(GetParam(), test::random_parameters(random_, GetParam()));
    const std::vector<RawPair> pairs =
        test::random_pairs(random_, 3 + trial % 6, truth, kSigma_mm, false);
    const internal::RawFitResult result = fit_raw(pairs, GetParam());
    ASSERT_TRUE(result.fit.has_value());
    const Eigen::Matrix<double, 6, 6> theirs = judge(pairs, GetParam()).cov;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const double size = std::sqrt(theirs(i, i) * theirs(j, j));
        const double difference = std::abs(result.fit->cov(i, j) - theirs(i, j));
        worst = std::max(worst, size > 0 ? difference / size : difference);
      }
    }
  }
  RecordProperty("worst_relative", testing::PrintToString(worst));
  EXPECT_LE(worst, 1e-8);
}

TEST_P(PanelFitAgainstCeres, FindsTheSameMapFromSlots) {
  double worst_mm = 0;
  double worst_chi_square = 0;
  double worst_cov = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    // Residuals of a few sigma only: what they bend, the covariance that Ceres leaves out, is their
    // ratio to the distances.
    const Coefficients truth =
        internal::coefficients(GetParam(), test::random_parameters(random_, GetParam()));
    const std::vector<RawPair> pairs =
        test::random_slots(random_, 3 + trial % 4, trial % 3, truth, kSigma_mm, true);
    const internal::RawFitResult result = fit_raw(pairs, GetParam());
    ASSERT_TRUE(result.fit.has_value());
    const Judgement judgement = judge(pairs, GetParam());
    for (const RawPair& pair : pairs) {
      const Eigen::Vector2d ours_mm = test::mapped(coefficients_of(*result.fit), pair.from_mm);
      const Eigen::Vector2d theirs_mm = test::mapped(judgement.a, pair.from_mm);
      worst_mm = std::max(worst_mm, (ours_mm - theirs_mm).norm());
    }
    worst_chi_square = std::max(
        worst_chi_square,
        std::abs(result.fit->chi_square - judgement.chi_square) / (1 + judgement.chi_square));
    worst_cov =
        std::max(worst_cov, (result.fit->cov - judgement.cov).norm() / judgement.cov.norm());
  }
  RecordProperty("worst_mm", testing::PrintToString(worst_mm));
  RecordProperty("worst_chi_square", testing::PrintToString(worst_chi_square));
  RecordProperty("worst_cov", testing::PrintToString(worst_cov));
  const bool is_linear = internal::is_linear(GetParam());
  EXPECT_LE(worst_mm, is_linear ? kAgreement_mm : kAgreementOfIterations_mm);
  EXPECT_LE(worst_chi_square, 1e-9);
  EXPECT_LE(worst_cov, is_linear ? 1e-9 : 1e-3);
}

INSTANTIATE_TEST_SUITE_P(EveryModel,
                         PanelFitAgainstCeres,
                         testing::ValuesIn(kAllModels),
                         [](const auto& model) { return std::string(name(model.param)); });

}  // namespace
}  // namespace panelcal
