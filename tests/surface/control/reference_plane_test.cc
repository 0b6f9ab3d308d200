// SPDX-License-Identifier: Apache-2.0
#include "surface/control/reference_plane.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::chi_square_agrees;
using test::IsNearMatrix;
using test::mean_agrees;

using Probes = std::vector<ProbedHeight>;

/// Rounding of coordinates of 500 mm.
constexpr double kRounding_mm = 1e-12;

Position<frame::Machine> at(double x_mm, double y_mm) {
  return position_mm<frame::Machine>(x_mm, y_mm);
}

/// A board 1.6 mm thick that rises by 1 mm per m along x and falls by 2 mm per m along y.
double true_height_mm(double x_mm, double y_mm) {
  return 1.6 + 1e-3 * x_mm - 2e-3 * y_mm;
}

ProbedHeight probe(double x_mm, double y_mm, double sigma_mm = 0.002) {
  return {at(x_mm, y_mm), {mm(true_height_mm(x_mm, y_mm)), mm(sigma_mm)}};
}

Probes grid() {
  Probes probes;
  for (const double x_mm : {0.0, 150.0, 320.0, 500.0}) {
    for (const double y_mm : {0.0, 210.0, 400.0}) {
      probes.push_back(probe(x_mm, y_mm, 0.001 + 1e-5 * x_mm));
    }
  }
  return probes;
}

void expect_fails(const Probes& probes, PlaneFailure failure) {
  const ReferencePlaneResult result = fit_reference_plane(probes);
  ASSERT_FALSE(result.plane.has_value());
  EXPECT_EQ(result.failure, failure);
}

TEST(ReferencePlane, RecoversAPlaneExactly) {
  for (const Probes& probes : {grid(), Probes{probe(0, 0), probe(500, 0), probe(0, 400)}}) {
    const ReferencePlaneResult result = fit_reference_plane(probes);
    ASSERT_TRUE(result.plane.has_value());
    EXPECT_THAT(result.plane->slope(), IsNearMatrix(Eigen::Vector2d(1e-3, -2e-3), 1e-15));
    EXPECT_NEAR(
        result.plane->height_at(at(77, 390)).height.in_mm(), true_height_mm(77, 390), kRounding_mm);
    EXPECT_EQ(result.plane->degrees_of_freedom(), static_cast<int>(probes.size()) - 3);
    EXPECT_LT(result.plane->chi_square(), 1e-18);
    EXPECT_EQ(result.plane->residuals().size(), probes.size());
  }
}

TEST(ReferencePlane, KeepsItsDigitsFarFromMachineZero) {
  Probes probes;
  for (const ProbedHeight& p : grid()) {
    probes.push_back({at(p.position.in_mm().x() + 1e6, p.position.in_mm().y()), p.measured});
  }
  probes[4].measured.height = probes[4].measured.height + um(10);
  Probes near = grid();
  near[4].measured.height = near[4].measured.height + um(10);
  const auto far_plane = fit_reference_plane(probes).plane;
  const auto near_plane = fit_reference_plane(near).plane;
  ASSERT_TRUE(far_plane && near_plane);
  EXPECT_NEAR(far_plane->residuals()[4].in_um(), near_plane->residuals()[4].in_um(), 1e-6);
}

TEST(ReferencePlane, ResidualsAreMeasuredMinusFitted) {
  // Four corners, one 4 um high: the plane takes 3 um of it there.
  Probes probes = {probe(0, 0), probe(100, 0), probe(0, 100), probe(100, 100)};
  probes[3].measured.height = probes[3].measured.height + um(4);
  const auto plane = fit_reference_plane(probes).plane;
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->residuals()[0].in_um(), 1, 1e-9);
  EXPECT_NEAR(plane->residuals()[1].in_um(), -1, 1e-9);
  EXPECT_NEAR(plane->residuals()[2].in_um(), -1, 1e-9);
  EXPECT_NEAR(plane->residuals()[3].in_um(), 1, 1e-9);
  // Four residuals of 1 um against a sigma of 2 um.
  EXPECT_NEAR(plane->chi_square(), 1, 1e-9);
}

TEST(ReferencePlane, KnowsHowWellItKnows) {
  // Textbook: n probes of sigma s on a centred square of half side h; variance of the height at
  // (x, y) is s^2 (1/n + x^2 / (n h^2) + y^2 / (n h^2)).
  const Probes probes = {probe(-50, -50), probe(50, -50), probe(-50, 50), probe(50, 50)};
  const auto plane = fit_reference_plane(probes).plane;
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->height_at(at(0, 0)).sigma.in_um(), 1.0, 1e-9);
  EXPECT_NEAR(plane->height_at(at(50, 50)).sigma.in_um(), std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(plane->height_at(at(100, 0)).sigma.in_um(), std::sqrt(5.0), 1e-9);
  const Eigen::Matrix2d expected = 4e-6 / 1e4 * Eigen::Matrix2d::Identity();
  EXPECT_THAT(plane->slope_covariance(), IsNearMatrix(expected, 1e-24));
}

TEST(ReferencePlane, ErrsAsItSays) {
  constexpr int kTrials = 2000;
  Random random(301);
  double residual_chi_square = 0;
  double height_chi_square = 0;
  double error_sum = 0;
  int dof = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Probes probes = grid();
    for (ProbedHeight& p : probes) {
      p.measured.height = p.measured.height + random.normal() * p.measured.sigma;
    }
    const auto plane = fit_reference_plane(probes).plane;
    ASSERT_TRUE(plane);
    residual_chi_square += plane->chi_square();
    dof += plane->degrees_of_freedom();
    const HeightEstimate height = plane->height_at(at(480, 30));
    const double error = (height.height.in_mm() - true_height_mm(480, 30)) / height.sigma.in_mm();
    height_chi_square += error * error;
    error_sum += error;
  }
  EXPECT_TRUE(chi_square_agrees(residual_chi_square, dof));
  EXPECT_TRUE(chi_square_agrees(height_chi_square, kTrials));
  EXPECT_TRUE(mean_agrees(error_sum / kTrials, 0, 1, kTrials));
}

TEST(ReferencePlane, RefusesTooFewProbes) {
  expect_fails({}, PlaneFailure::TooFewProbes);
  expect_fails({probe(0, 0), probe(1, 0)}, PlaneFailure::TooFewProbes);
}

TEST(ReferencePlane, RefusesProbesInOneLine) {
  for (double angle_rad = 0; angle_rad < 3.2; angle_rad += 0.1) {
    SCOPED_TRACE(angle_rad);
    Probes probes;
    for (const double along_mm : {0.0, 130.0, 410.0}) {
      probes.push_back(
          probe(900 + along_mm * std::cos(angle_rad), along_mm * std::sin(angle_rad) - 300));
    }
    expect_fails(probes, PlaneFailure::Collinear);
  }
  expect_fails({probe(3, 4), probe(3, 4), probe(3, 4)}, PlaneFailure::Collinear);
  expect_fails({probe(3, 4), probe(3, 4), probe(5, 4)}, PlaneFailure::Collinear);
}

TEST(ReferencePlane, RefusesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad_sigma_mm : {0.0, -0.001, nan, inf, 1e-200}) {
    Probes probes = grid();
    probes[2].measured.sigma = mm(bad_sigma_mm);
    expect_fails(probes, PlaneFailure::BadSigma);
  }
  Probes probes = grid();
  probes[2].measured.height = mm(nan);
  expect_fails(probes, PlaneFailure::BadSigma);
  probes = grid();
  probes[2].position = at(inf, 0);
  expect_fails(probes, PlaneFailure::BadSigma);
}

}  // namespace
}  // namespace panelcal
