// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/model.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/statistics/random.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

CellPattern square(double side) {
  return {{-side / 2, side / 2}, {-side / 2, side / 2}, {Cell::Target}, Cell::Background, {}, {}};
}

CellPattern cross(double length, double width) {
  const std::vector<double> lines = {-length / 2, -width / 2, width / 2, length / 2};
  const auto T = Cell::Target;
  const auto B = Cell::Background;
  return {lines, lines, {B, T, B, T, T, T, B, T, B}, B, {-1, -1, 1, 1}, {-1, -1, 1, 1}};
}

/// A grid of 4 px cells, as small as those of a tag seen from afar.
CellPattern checkers(Random& random) {
  CellPattern pattern;
  for (int i = 0; i <= 6; ++i) {
    pattern.x.push_back(4.0 * i - 12);
    pattern.y.push_back(4.0 * i - 12);
  }
  for (int i = 0; i < 36; ++i) {
    pattern.cells.push_back(random.uniform(0, 1) < 0.5 ? Cell::Target : Cell::Background);
  }
  return pattern;
}

CellPixel pixel_at(const Eigen::Vector2d& at) {
  CellPixel pixel;
  pixel.at = at;
  pixel.jacobian.setIdentity();
  return pixel;
}

double phi(double t) {
  return 0.5 * std::erfc(-t / std::numbers::sqrt2);
}

/// Share that a pixel sees of a drawing that is only turned and enlarged, by Gauss-Legendre
/// quadrature of the pixel's square over the lens's blur: exact to 1e-9, and nothing in common with
/// the model.
double exact_share(const CellPattern& pattern,
                   const CellState& state,
                   double lens_px,
                   const Eigen::Vector2d& u) {
  constexpr std::array kPlaces = {
      -0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array kWeights = {0.2369268850561891,
                                   0.4786286704993665,
                                   0.5688888888888889,
                                   0.4786286704993665,
                                   0.2369268850561891};
  const double lens = lens_px * std::sqrt(std::abs(state.jacobian(u).determinant()));
  double sum = 0;
  for (std::size_t a = 0; a < kPlaces.size(); ++a) {
    for (std::size_t b = 0; b < kPlaces.size(); ++b) {
      const Eigen::Vector2d offset(0.5 * kPlaces[a], 0.5 * kPlaces[b]);
      const Eigen::Vector2d v = state.to_pattern(u + offset);
      double share = 0;
      for (int j = 0; j < pattern.n_rows(); ++j) {
        for (int i = 0; i < pattern.n_columns(); ++i) {
          if (pattern.at(i, j) != Cell::Target) continue;
          const auto x = static_cast<std::size_t>(i);
          const auto y = static_cast<std::size_t>(j);
          share += (phi((v.x() - pattern.x[x]) / lens) - phi((v.x() - pattern.x[x + 1]) / lens)) *
                   (phi((v.y() - pattern.y[y]) / lens) - phi((v.y() - pattern.y[y + 1]) / lens));
        }
      }
      sum += 0.25 * kWeights[a] * kWeights[b] * share;
    }
  }
  return sum;
}

double largest_share_error(const CellPattern& pattern, double lens_px, std::uint64_t seed) {
  Random random(seed);
  double error = 0;
  for (int i = 0; i < 20; ++i) {
    CellState state = placed({random.uniform(-1, 1), random.uniform(-1, 1)},
                             random.uniform(-4, 4),
                             random.uniform(0.9, 1.2));
    state.sigma_px = std::sqrt(lens_px * lens_px + 1.0 / 12);
    const CellModel model(pattern, PoseKind::Similarity, {0, 0}, 20);
    for (int k = 0; k < 400; ++k) {
      const Eigen::Vector2d u(random.uniform(-22, 22), random.uniform(-22, 22));
      const auto value = CellView(model, state).evaluate(pixel_at(u), nullptr);
      error = std::max(error, std::abs(value.share - exact_share(pattern, state, lens_px, u)));
    }
  }
  return error;
}

// A lens of 0.5 px is nearly a point: Edgeworth's next term is what is left.
TEST(CellModel, ShareIsExactBehindASharpLens) {
  Random random(1);
  EXPECT_LT(largest_share_error(square(24), 0.5, 2), 6e-4);
  EXPECT_LT(largest_share_error(cross(30, 8), 0.5, 3), 6e-4);
  EXPECT_LT(largest_share_error(checkers(random), 0.5, 4), 6e-4);
}

TEST(CellModel, ShareIsExactBehindAnOrdinaryLens) {
  Random random(1);
  EXPECT_LT(largest_share_error(square(24), 1.0, 2), 5e-5);
  EXPECT_LT(largest_share_error(cross(30, 8), 1.0, 3), 5e-5);
  EXPECT_LT(largest_share_error(checkers(random), 1.0, 4), 5e-5);
}

CellState tilted(Random& random) {
  CellState state = placed({random.uniform(-1, 1), random.uniform(-1, 1)}, 0.3, 1.1);
  Eigen::Matrix3d tilt = Eigen::Matrix3d::Identity();
  tilt(0, 1) = random.uniform(-0.1, 0.1);
  tilt(1, 1) = random.uniform(0.9, 1.1);
  tilt(2, 0) = random.uniform(-2e-3, 2e-3);
  tilt(2, 1) = random.uniform(-2e-3, 2e-3);
  state.pattern_from_frame = state.pattern_from_frame * tilt;
  state.sigma_px = 1.3;
  state.growth = 0.2;
  state.levels << 80, 3, -4, 100, 5, 6;
  return state;
}

/// Largest difference of the gradient from numeric differentiation, over the contrast.
double largest_gradient_error(const CellPattern& pattern, PoseKind kind) {
  Random random(5);
  const CellModel model(pattern, kind, {0.3, -0.2}, 20);
  constexpr double kStep = 1e-4;
  double error = 0;
  for (int i = 0; i < 200; ++i) {
    const CellState state =
        kind == PoseKind::Similarity ? [&] {
          CellState plain = placed({0.2, 0.1}, 0.3, 1.1);
          plain.sigma_px = 1.3;
          plain.levels << 80, 3, -4, 100, 5, 6;
          return plain;
        }()
                                     : tilted(random);
    const CellPixel pixel = pixel_at({random.uniform(-18, 18), random.uniform(-18, 18)});
    CellVector gradient;
    CellView(model, state).evaluate(pixel, &gradient);
    for (int k = 0; k < model.n_parameters(); ++k) {
      CellVector step = CellVector::Zero();
      step[k] = kStep;
      const double above = CellView(model, model.moved(state, step)).evaluate(pixel, nullptr).level;
      step[k] = -kStep;
      const double below = CellView(model, model.moved(state, step)).evaluate(pixel, nullptr).level;
      const double numeric = (above - below) / (2 * kStep);
      // Generators grow with the distance from the middle: so may their errors.
      const double unit = k < 2 || k >= model.n_pose() ? 1 : k < 6 ? 15 : 225;
      error = std::max(error, std::abs(gradient[k] - numeric) / unit / 100);
    }
  }
  return error;
}

// The direction of an edge changes its fourth cumulant, which the gradient leaves out: 1e-4.
constexpr double kGradientError = 5e-4;

TEST(CellModel, GradientsAgreeWithDifferences) {
  Random random(1);
  for (const PoseKind kind : {PoseKind::Similarity, PoseKind::Affine, PoseKind::Homography}) {
    EXPECT_LT(largest_gradient_error(square(24), kind), kGradientError) << int(kind);
    EXPECT_LT(largest_gradient_error(cross(30, 8), kind), kGradientError) << int(kind);
    EXPECT_LT(largest_gradient_error(checkers(random), kind), kGradientError) << int(kind);
  }
}

TEST(CellModel, PlaceGradientAgreesWithDifferences) {
  Random random(6);
  const CellModel model(square(24), PoseKind::Homography, {0, 0}, 20);
  const CellState state = tilted(random);
  const Eigen::Vector2d corner(12, -12);
  const auto gradient = model.place_gradient(state, corner);
  for (int k = 0; k < model.n_parameters(); ++k) {
    CellVector step = CellVector::Zero();
    step[k] = 1e-6;
    const Eigen::Vector2d numeric =
        (model.moved(state, step).to_frame(corner) - state.to_frame(corner)) / 1e-6;
    EXPECT_LT((numeric - gradient.col(k)).norm(), 1e-3 * (1 + gradient.col(k).norm())) << k;
  }
}

TEST(CellModel, PixelsThatSeeUnknownCellsDoNotCount) {
  CellPattern pattern = square(24);
  pattern.outside = Cell::Unknown;
  const CellModel model(pattern, PoseKind::Similarity, {0, 0}, 20);
  const CellState state = placed({0, 0}, 0, 1);
  EXPECT_TRUE(CellView(model, state).evaluate(pixel_at({0, 0}), nullptr).is_known);
  EXPECT_FALSE(CellView(model, state).evaluate(pixel_at({11, 0}), nullptr).is_known);
  EXPECT_FALSE(CellView(model, state).evaluate(pixel_at({20, 0}), nullptr).is_known);
}

TEST(CellModel, FlatPixelsAreThoseThatSeeNoLine) {
  const CellModel model(cross(40, 16), PoseKind::Similarity, {0, 0}, 20);
  const CellState state = placed({0, 0}, 0, 1);
  EXPECT_EQ(CellView(model, state).flat_share(pixel_at({0, 0}), 1), 1.0);
  EXPECT_EQ(CellView(model, state).flat_share(pixel_at({8, 0}), 1),
            1.0);  // the line ends at the bars
  EXPECT_EQ(CellView(model, state).flat_share(pixel_at({8, 14}), 1), std::nullopt);
  EXPECT_EQ(CellView(model, state).flat_share(pixel_at({20, 15}), 1), 0.0);
}

}  // namespace
}  // namespace panelcal::internal
