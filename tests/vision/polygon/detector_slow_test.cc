// SPDX-License-Identifier: Apache-2.0
// Truth first: error and covariance of squares, diamonds, crosses and slots against the bound that
// numeric derivatives of the rendered pictures give, all nuisance parameters unknown.
#include <cmath>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "tests/vision/polygon/trial.h"

namespace panelcal::test {
namespace {

/// The ratio's own standard deviation over 300 pictures of two numbers each.
constexpr double kRatioSigma = 0.03;
/// 300 draws of two numbers each: one standard deviation of the mean is 0.06.
constexpr double kNeesTolerance = 0.17;

CellStatistics run_and_show(const CellTrialOptions& options) {
  const CellStatistics s = run_cell_trials(options);
  std::cout << name(options.shape) << ": " << s.text() << '\n';
  return s;
}

void expect_good(const CellStatistics& s, double max_ratio) {
  EXPECT_EQ(s.n_found, s.n) << s.first_failure;
  EXPECT_LT(s.ratio, max_ratio + 2 * kRatioSigma) << s.text();
  EXPECT_GT(s.nees, 1 - kNeesTolerance) << s.text();
  EXPECT_LT(s.nees, 1 + kNeesTolerance) << s.text();
  EXPECT_LT(std::abs(s.mean_px.x()), 4 * s.rmse_px.x() / std::sqrt(s.n_found)) << s.text();
  EXPECT_LT(std::abs(s.mean_px.y()), 4 * s.rmse_px.y() / std::sqrt(s.n_found)) << s.text();
}

class CellAccuracy : public ::testing::TestWithParam<Shape> {};

TEST_P(CellAccuracy, ReachesTheBoundInCleanPictures) {
  CellTrialOptions options;
  options.shape = GetParam();
  expect_good(run_and_show(options), 1.05);
}

TEST_P(CellAccuracy, ReachesTheBoundBehindALensInUnevenLight) {
  CellTrialOptions options;
  options.shape = GetParam();
  options.contrast = 100;
  options.noise = 5;
  options.blur_px = 1.5;
  options.light_gradient = 0.2;
  options.with_mapping = true;
  options.lens_at_corner_px = 1;
  expect_good(run_and_show(options), 1.1);
}

/// The bound is that of white noise alone: coloured noise costs what it costs.
TEST_P(CellAccuracy, IsHonestOnWeave) {
  CellTrialOptions options;
  options.shape = GetParam();
  options.n = 200;
  options.contrast = 100;
  options.noise = 5;
  options.blur_px = 1.5;
  options.weave = 8;
  options.light_gradient = 0.2;
  const CellStatistics s = run_and_show(options);
  EXPECT_EQ(s.n_found, s.n) << s.first_failure;
  EXPECT_LT(s.ratio, 1.6) << s.text();
  EXPECT_GT(s.nees, 0.75) << s.text();
  EXPECT_LT(s.nees, 1.25) << s.text();
}

TEST_P(CellAccuracy, StaysNearTheBoundUnderDebris) {
  CellTrialOptions options;
  options.shape = GetParam();
  options.polarity = Polarity::Dark;
  options.contrast = 40;
  options.noise = 12;
  options.blur_px = 2.5;
  options.debris = 0.1;
  const CellStatistics s = run_and_show(options);
  EXPECT_GE(s.n_found, 0.99 * s.n) << s.first_failure;
  EXPECT_LT(s.ratio, 2.5) << s.text();
  EXPECT_LT(s.worst, 1.5) << s.text();
  // Traces of debris stay in: the covariance counts with them, rather too much than too little.
  EXPECT_LT(s.nees, 1 + kNeesTolerance) << s.text();
}

/// Only the model's own error is left: 16 bit and next to no noise.
TEST_P(CellAccuracy, HasNoBiasByThePixelPhase) {
  for (const double size_px : {14.0, 40.0, 120.0}) {
    CellTrialOptions options;
    options.shape = GetParam();
    options.n = 40;
    options.size_px = size_px;
    options.full_scale = 65535;
    options.noise = 0.01;
    const CellStatistics s = run_and_show(options);
    EXPECT_EQ(s.n_found, s.n) << s.first_failure;
    constexpr double kMaxErrorPx = 0.001;
    EXPECT_LT(s.worst, kMaxErrorPx) << size_px << ": " << s.text();
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         CellAccuracy,
                         ::testing::Values(Shape::Square, Shape::Diamond, Shape::Cross),
                         [](const auto& shape) { return std::string(name(shape.param)); });

TEST(SlotAccuracy, IsHonestAcrossItself) {
  CellTrialOptions options;
  options.shape = Shape::Slot;
  options.size_px = 40;
  // Its ends at the picture's border are left out.
  expect_good(run_and_show(options), 1.1);
}

}  // namespace
}  // namespace panelcal::test
