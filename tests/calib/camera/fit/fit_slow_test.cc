// SPDX-License-Identifier: Apache-2.0
// Does the camera fit err as it says? Seeded draws around known truth.
#include <cmath>
#include <iostream>
#include <limits>

#include "calib/camera/fit/fit.h"
#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::chi_square_agrees;
using test::mean_agrees;

constexpr int kTrials = 500;
constexpr double kNoise_px = 0.02;

CameraFitOptions options_for(const CameraModel::Parameters& truth) {
  CameraFitOptions options;
  options.form = CameraForm::Tangential;
  options.axis_px = truth.axis_px;
  options.focal_px = truth.focal_px;
  options.rotation_rad = truth.rotation_rad;
  return options;
}

Eigen::Matrix<double, kCameraParameters, 1> values(const CameraModel::Parameters& p) {
  Eigen::Matrix<double, kCameraParameters, 1> v;
  v << p.scale_mm_per_px, p.rotation_rad, p.tilt, p.k1_per_px2, p.k2_per_px4, p.p1_per_px,
      p.p2_per_px;
  return v;
}

/// Errors of the free parameters, in sigmas, squared.
double chi_square_of(const CameraFit& fit, const CameraModel::Parameters& truth, int& dof) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < kCameraParameters; ++i) {
    if (fit.covariance(i, i) > 0) free.push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::VectorXd error(n);
  Eigen::MatrixXd cov(n, n);
  const auto off = values(fit.parameters) - values(truth);
  for (Eigen::Index a = 0; a < n; ++a) {
    const Eigen::Index i = free[static_cast<std::size_t>(a)];
    const double sigma_a = std::sqrt(fit.covariance(i, i));
    error[a] = off[i] / sigma_a;
    for (Eigen::Index b = 0; b < n; ++b) {
      const Eigen::Index j = free[static_cast<std::size_t>(b)];
      cov(a, b) = fit.covariance(i, j) / (sigma_a * std::sqrt(fit.covariance(j, j)));
    }
  }
  dof += static_cast<int>(n);
  return error.dot(cov.llt().solve(error));
}

void expect_honest(const CameraData& exact, const CameraModel::Parameters& truth, int seed) {
  double errors = 0;
  double residuals = 0;
  double held_out_px2 = 0;
  int error_dof = 0;
  int residual_dof = 0;
  CameraFitOptions options = options_for(truth);
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(static_cast<std::uint64_t>(seed + trial));
    CameraData data = exact;
    test::add_noise(random, kNoise_px, data);
    options.held_out_every = trial < 50 ? 5 : 0;
    const auto fit = fit_camera(data, options);
    ASSERT_TRUE(fit) << fit.error().text();
    errors += chi_square_of(*fit, truth, error_dof);
    residuals += fit->chi_square;
    residual_dof += fit->degrees_of_freedom;
    if (trial < 50) held_out_px2 += *fit->held_out_rms_px * *fit->held_out_rms_px / 50;
  }
  const double per_dof = errors / error_dof;
  std::cout << "chi square per d.o.f. " << per_dof << ", held out " << std::sqrt(held_out_px2)
            << " px\n";
  EXPECT_TRUE(chi_square_agrees(errors, error_dof));
  EXPECT_TRUE(chi_square_agrees(residuals, residual_dof));
  EXPECT_GT(per_dof, 0.9);
  EXPECT_LT(per_dof, 1.1);
  EXPECT_LE(std::sqrt(held_out_px2), 0.030);
}

TEST(CameraFitStatistics, APlateLaidAnewErrsAsItsCovarianceSays) {
  const CameraModel truth(test::bent_camera());
  expect_honest(test::plate_views(truth, mm(0.15)), truth.parameters(), 1000);
}

TEST(CameraFitStatistics, OneTargetAtKnownPlacesErrsAsItsCovarianceSays) {
  const CameraModel truth(test::bent_camera());
  expect_honest(test::target_views(truth, 11, mm(0.15)), truth.parameters(), 3000);
}

TEST(CameraFitStatistics, AnUncertifiedPlateErrsAsItsCovarianceSays) {
  const CameraModel truth(test::bent_camera());
  CameraData exact = test::plate_views(truth, mm(0));
  for (PlateDot& dot : exact.dots) dot.is_certified = false;
  CameraFitOptions options = options_for(truth.parameters());
  options.scale_mm_per_px = truth.parameters().scale_mm_per_px;
  options.held_out_every = 0;
  double errors = 0;
  int dof = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(static_cast<std::uint64_t>(5000 + trial));
    CameraData data = exact;
    test::add_noise(random, kNoise_px, data);
    const auto fit = fit_camera(data, options);
    ASSERT_TRUE(fit) << fit.error().text();
    errors += chi_square_of(*fit, truth.parameters(), dof);
  }
  std::cout << "chi square per d.o.f. " << errors / dof << "\n";
  EXPECT_TRUE(chi_square_agrees(errors, dof));
}

TEST(ChooseCameraStatistics, HoldsTheScaleWhereAFlatCameraWouldDo) {
  // A lens bent by one and a half sigmas of k1: Akaike's criterion allows the flat form in most
  // draws, and with that form 95 % intervals held the scale in three of ten.
  CameraModel::Parameters p = test::straight_camera();
  p.focal_px = std::numeric_limits<double>::infinity();
  CameraData straight = test::target_views(CameraModel(p), 5, mm(0));
  Random none(1);
  test::add_noise(none, kNoise_px, straight);
  CameraFitOptions options = options_for(p);
  options.form = CameraForm::Radial;
  options.held_out_every = 0;
  const auto radial = fit_camera(straight, options);
  ASSERT_TRUE(radial) << radial.error().text();
  constexpr auto kK1 = static_cast<Eigen::Index>(CameraParameter::K1);
  p.k1_per_px2 = 1.5 * std::sqrt(radial->covariance(kK1, kK1));
  const CameraData exact = test::target_views(CameraModel(p), 5, mm(0));
  constexpr int kDraws = 400;
  int inside = 0;
  int would_do = 0;
  for (int trial = 0; trial < kDraws; ++trial) {
    Random random(static_cast<std::uint64_t>(9000 + trial));
    CameraData data = exact;
    test::add_noise(random, kNoise_px, data);
    const auto fit = choose_camera(data, options);
    ASSERT_TRUE(fit) << fit.error().text();
    would_do += fit->sufficient == CameraForm::Flat;
    const double error = fit->parameters.scale_mm_per_px - p.scale_mm_per_px;
    inside += std::abs(error) <= 1.96 * std::sqrt(fit->covariance(0, 0));
  }
  std::cout << inside << " of " << kDraws << " held, flat would do in " << would_do << "\n";
  EXPECT_GT(would_do, kDraws / 2);
  EXPECT_GE(inside, 0.92 * kDraws);
  EXPECT_LE(inside, 0.98 * kDraws);
}

TEST(ChooseCameraStatistics, CallsASofterFormNeededOnlyNowAndThen) {
  CameraModel::Parameters p = test::straight_camera();
  const CameraData exact = test::plate_views(CameraModel(p), mm(0));
  CameraFitOptions options = options_for(p);
  options.held_out_every = 0;
  constexpr int kDraws = 200;
  int softer = 0;
  for (int trial = 0; trial < kDraws; ++trial) {
    Random random(static_cast<std::uint64_t>(7000 + trial));
    CameraData data = exact;
    test::add_noise(random, kNoise_px, data);
    const auto fit = choose_camera(data, options);
    ASSERT_TRUE(fit) << fit.error().text();
    softer += fit->sufficient != CameraForm::Flat;
  }
  std::cout << softer << " of " << kDraws << " softer\n";
  // k1 gains 4 by chance once in 22, each further form less; all together once in 7 or so.
  EXPECT_LE(softer, kDraws / 5);
}

}  // namespace
}  // namespace panelcal
