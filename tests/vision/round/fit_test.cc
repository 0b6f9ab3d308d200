// SPDX-License-Identifier: Apache-2.0
#include "vision/round/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/vision/round/model/rim_value.h"
#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

constexpr int kSide = 160;
constexpr double kBand = 6;  // px, beyond the foot of the edge
constexpr double kOutside = 25;

/// A disc, or a ring with an off-centre hole, in the exact picture of a camera.
struct Mark {
  Scene scene;
  Camera camera = test::plain_camera(kSide, kSide);
  Eigen::Vector2d center_px;
  RimVector truth = RimVector::Zero();
};

Mark make_mark(double radius, bool is_ring, double level, double contrast) {
  Mark mark;
  mark.center_px = {79.3, 80.8};
  Feature feature = test::disc_at(mark.camera, mark.center_px.x(), mark.center_px.y(), radius, 0);
  mark.scene.background = level / 255;
  feature.level = (level + contrast) / 255;
  RimVector& p = mark.truth;
  p[kRadius] = radius;
  p[kSigma] = std::sqrt(1 + kPixelVariance);
  p[kLevel] = level;
  p[kContrast] = contrast;
  if (is_ring) {
    feature.shape = Feature::Shape::Ring;
    feature.inner_size = 0.5 * feature.size;
    // A plain camera has 0.01 mm per px and y upwards.
    feature.hole_offset = displacement_mm<frame::Optical>(Eigen::Vector2d(0.02, 0.01));
    p[kInnerRadius] = 0.5 * radius;
    p[kHoleX] = 2;
    p[kHoleY] = -1;
  }
  mark.scene.features = {feature};
  return mark;
}

Image noiseless(const Mark& mark) {
  Image image(kSide, kSide, 255);
  const std::vector<double> levels = render_levels(mark.scene, mark.camera);
  std::transform(levels.begin(), levels.end(), image.pixels().begin(), [](double v) {
    return static_cast<float>(v);
  });
  return image;
}

void expect_found_from(const Mark& mark, bool is_ring, const RimVector& start) {
  const Image image = noiseless(mark);
  const FitFrame frame(nullptr, mark.center_px);
  RimWindow window(image, frame, start, kOutside, is_ring);
  window.collect(start, kBand, 1);
  RimFitOptions options;
  options.freedom.is_ring = is_ring;
  const RimSolution solution = fit_rim(window, start, options);
  ASSERT_TRUE(solution.converged);
  EXPECT_LE(solution.n_evaluations, 10);
  // The band was made for the start, which cuts a foot of the edge.
  constexpr double kModelError_px = 0.002;
  const RimVector error = solution.parameters - mark.truth;
  for (const int i : {kCenterX, kCenterY, kRadius, kInnerRadius}) {
    EXPECT_LT(std::abs(error[i]), kModelError_px) << i;
  }
  EXPECT_LT(std::abs(error[kSigma]), 0.01);
  for (const int i : {kHoleX, kHoleY}) EXPECT_LT(std::abs(error[i]), 2 * kModelError_px) << i;
  for (const int i : {kLevel, kContrast}) EXPECT_LT(std::abs(error[i]), 0.05) << i;
}

TEST(RimFit, FindsTheRimFromPoorStarts) {
  for (const double radius : {12.0, 40.0}) {
    for (const bool is_ring : {false, true}) {
      for (int i = 0; i < 8; ++i) {
        const double turn = std::numbers::pi * i / 4;
        const Mark mark = make_mark(radius, is_ring, 80, i % 2 == 0 ? 100 : -60);
        RimVector start = mark.truth;
        start[kCenterX] += 0.5 * std::cos(turn);
        start[kCenterY] += 0.5 * std::sin(turn);
        start[kRadius] += i < 4 ? 0.5 : -0.5;
        start[kSigma] *= i % 2 == 0 ? 1.2 : 0.8;
        start[kLevel] += 10;
        start[kContrast] *= 0.85;
        if (is_ring) start.segment<2>(kHoleX).setZero();
        SCOPED_TRACE(testing::Message() << "radius " << radius << " ring " << is_ring << " " << i);
        expect_found_from(mark, is_ring, start);
      }
    }
  }
}

/// Edges that are not the rim make Gauss-Newton steps overshoot to and fro: beside a faint disc and
/// strong debris the fit must settle all the same.
TEST(RimFit, SettlesBesideDebrisAndNeighbours) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    Mark mark = make_mark(35, false, 110, 25);
    mark.camera.blur_px = 2.5;
    mark.truth[kSigma] = std::sqrt(2.5 * 2.5 + kPixelVariance);
    for (int i = 0; i < 10; ++i) {
      const bool is_debris = i < 7;
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const double distance = is_debris ? 35 : random.uniform(55, 62);
      mark.scene.features.push_back(test::disc_at(mark.camera,
                                                  mark.center_px.x() + distance * std::cos(angle),
                                                  mark.center_px.y() + distance * std::sin(angle),
                                                  is_debris ? random.uniform(2, 5) : 14,
                                                  is_debris ? random.uniform() : 135.0 / 255));
    }
    const Image image = noiseless(mark);
    RimWindow window(image, FitFrame(nullptr, mark.center_px), mark.truth, kOutside, false);
    window.collect(mark.truth, 12, 1);
    RimFitOptions options;
    EXPECT_TRUE(fit_rim(window, mark.truth, options).converged) << "seed " << seed;
  }
}

TEST(RimFit, InformationIsThatOfAllPixels) {
  const Mark mark = make_mark(30, true, 80, 100);
  const Image image = noiseless(mark);
  const FitFrame frame(nullptr, mark.center_px);
  RimWindow window(image, frame, mark.truth, kOutside, true);
  window.collect(mark.truth, kBand, 1);
  RimFitOptions options;
  options.freedom = {.is_ring = true, .is_oval = true, .has_own_slope = true};
  options.noise.sigma = {2, 2, 2};
  set_weights(window, mark.truth, options.noise);
  const RimSolution solution = fit_rim(window, mark.truth, options);
  Eigen::MatrixXd exact = Eigen::MatrixXd::Zero(kRimParameters, kRimParameters);
  for (const RimSpan& span : window.spans()) {
    for (int x = span.x0; x < span.x1; ++x) {
      RimPixel pixel;
      pixel.at =
          frame.from_image(Eigen::Vector2d(window.x0() + x, window.y0() + span.y)).cast<float>();
      pixel.jacobian.setIdentity();
      pixel.plane = window.plane_at(x, span.y).cast<float>();
      RimGradient g{};
      rim_value(pixel, solution.parameters, true, &g);
      const Eigen::Map<const RimVector> row(g.data());
      exact += row * row.transpose() / 4;
    }
  }
  for (Eigen::Index i = 0; i < kRimParameters; ++i) {
    for (Eigen::Index j = 0; j < kRimParameters; ++j) {
      // The last step is not looked at again.
      EXPECT_NEAR(
          solution.information(i, j), exact(i, j), 2e-3 * std::sqrt(exact(i, i) * exact(j, j)))
          << i << " " << j;
    }
  }
}

TEST(RimFit, WeightsFollowTheZones) {
  const Mark mark = make_mark(30, false, 80, 100);
  const Image image = noiseless(mark);
  const FitFrame frame(nullptr, mark.center_px);
  RimWindow window(image, frame, mark.truth, kOutside, false);
  window.collect(mark.truth, kBand, 1);
  RimNoise noise;
  noise.sigma = {6, 2, 1};
  set_weights(window, mark.truth, noise);
  for (const RimPixel& pixel : pixels_of(window.band())) {
    const RimValue value = rim_value(pixel, mark.truth, false, nullptr);
    if (value.share > 1 - 1e-6) {
      ASSERT_NEAR(pixel.weight, 1 / 4.0, 1e-4);
    }
    if (value.share < 1e-6) {
      ASSERT_NEAR(pixel.weight, 1 / 36.0, 1e-4);
    }
    ASSERT_GE(pixel.weight, 1 / 36.0 - 1e-4);
    ASSERT_LE(pixel.weight, 1 / 4.0 + 1e-4);
  }
}

constexpr double kNoise = 4;

struct SaturatedFit {
  RimSolution solution;
  RimWindow window;
};

/// Contrast 200 above 80: the disc's 280 are clipped at 255.
SaturatedFit fit_saturated(const Mark& mark, const Image& image, bool knows) {
  const FitFrame frame(nullptr, mark.center_px);
  RimVector start = mark.truth;
  start[kContrast] = 175;
  SaturatedFit fit{{}, RimWindow(image, frame, start, kOutside, false)};
  fit.window.collect(start, kBand, 1);
  RimFitOptions options;
  options.noise.sigma = {kNoise, kNoise, kNoise};
  options.tolerance_px = 1e-5;
  set_weights(fit.window, start, options.noise);
  if (!knows) fit.window.band().has_clipped = false;
  fit.solution = fit_rim(fit.window, start, options);
  return fit;
}

/// -log likelihood of the window, straight from the definition.
double minus_log_likelihood(const RimWindow& window, const RimVector& p) {
  double sum = 0;
  for (const RimPixel& pixel : pixels_of(window.band())) {
    const double z =
        (static_cast<double>(pixel.value) - rim_value(pixel, p, false, nullptr).level) / kNoise;
    sum += pixel.clipped == 0 ? 0.5 * z * z
                              : -std::log(0.5 * std::erfc(pixel.clipped * z / std::numbers::sqrt2));
  }
  for (std::size_t i = 0; i < kRimZones; ++i) {
    const FlatMoments& m = window.flat()[i];
    Eigen::Vector3d level = zone_level(p, static_cast<RimZone>(i));
    level[0] -= static_cast<double>(window.reference());
    sum += 0.5 * level.dot(m.bb * level - 2 * m.bv) / (kNoise * kNoise);
  }
  return sum;
}

TEST(RimFit, SaturatedDiscIsAtTheMaximumOfItsLikelihood) {
  Mark mark = make_mark(30, false, 80, 200);
  mark.camera.noise = kNoise;
  Random random(11);
  const Image image = render(mark.scene, mark.camera, random);
  const SaturatedFit fit = fit_saturated(mark, image, true);
  ASSERT_TRUE(fit.solution.converged);
  for (int i = 0; i < kInnerRadius; ++i) {
    const double sigma = 1 / std::sqrt(fit.solution.information(i, i));
    RimVector high = fit.solution.parameters;
    RimVector low = high;
    const double step = 0.1 * sigma;
    high[i] += step;
    low[i] -= step;
    const double slope =
        (minus_log_likelihood(fit.window, high) - minus_log_likelihood(fit.window, low)) /
        (2 * step);
    // In standard deviations from the maximum.
    EXPECT_LT(std::abs(slope * sigma), 0.03) << "parameter " << i;
  }
}

TEST(RimFit, SaturatedDiscIsFittedWithoutBias) {
  constexpr int kDraws = 200;
  constexpr double kMaxBias_px = 0.01;
  Mark mark = make_mark(30, false, 80, 200);
  mark.camera.noise = kNoise;
  RimVector bias = RimVector::Zero();
  RimVector bias_if_ignored = RimVector::Zero();
  double nees = 0;
  for (int i = 0; i < kDraws; ++i) {
    Random random = Random(12).fork(static_cast<std::uint64_t>(i));
    const Image image = render(mark.scene, mark.camera, random);
    const SaturatedFit fit = fit_saturated(mark, image, true);
    ASSERT_TRUE(fit.solution.converged) << i;
    const RimVector error = fit.solution.parameters - mark.truth;
    bias += error / kDraws;
    const Eigen::MatrixXd cov = fit.solution.information.inverse();
    const Eigen::Matrix2d center_cov = cov.topLeftCorner<2, 2>();
    nees += error.head<2>().dot(center_cov.inverse() * error.head<2>()) / (2 * kDraws);
    bias_if_ignored +=
        (fit_saturated(mark, image, false).solution.parameters - mark.truth) / kDraws;
  }
  EXPECT_LT(bias.head<2>().norm(), kMaxBias_px);
  EXPECT_LT(std::abs(bias[kRadius]), kMaxBias_px);
  EXPECT_LT(std::abs(bias[kSigma]), kMaxBias_px);
  EXPECT_LT(std::abs(bias[kContrast]), 1);
  // The test can tell.
  EXPECT_GT(std::abs(bias_if_ignored[kRadius]), 3 * kMaxBias_px);
  // 400 numbers: one standard deviation is 0.07.
  EXPECT_NEAR(nees, 1, 0.2);
}

}  // namespace
}  // namespace panelcal::internal
