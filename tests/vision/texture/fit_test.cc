// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/fit.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace panelcal::internal {
namespace {

constexpr int kField = 256;  // px: waves around, so that only a part is used
constexpr int kWindow = 128;
constexpr Eigen::Index kParameters = 6;

/// A random field of the model's autocovariance, whose spectrum is (1 / range^2 + k^2)^-3 in two
/// dimensions (Whittle 1954), by the fast Fourier transform of white noise.
cv::Mat draw_field(const Texture& texture, Random& random) {
  cv::Mat white(kField, kField, CV_64F);
  for (int y = 0; y < kField; ++y) {
    for (int x = 0; x < kField; ++x) white.at<double>(y, x) = random.normal();
  }
  cv::Mat spectrum;
  cv::dft(white, spectrum, cv::DFT_COMPLEX_OUTPUT);
  const auto wave = [](int i) {
    return 2 * std::numbers::pi * (i < kField / 2 ? i : i - kField) / kField;
  };
  double power = 0;
  for (int y = 0; y < kField; ++y) {
    for (int x = 0; x < kField; ++x) {
      const double k2 = wave(x) * wave(x) + wave(y) * wave(y);
      const double s = std::pow(1 / (texture.range_px * texture.range_px) + k2, -3);
      power += s;
      spectrum.at<cv::Vec2d>(y, x) *= std::sqrt(s);
    }
  }
  cv::Mat field;
  cv::dft(spectrum, field, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return field * (texture.sigma / std::sqrt(power / (kField * kField)));
}

/// A blurred disc on textured ground, linearised: center, radius, background, contrast, blur.
struct Problem {
  std::vector<TexturedPixel> pixels;
  Eigen::MatrixXf jacobian;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kParameters, kParameters);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kParameters);
};

Problem draw_problem(const Texture& texture, Random& random) {
  constexpr double kRadius = 30;
  constexpr double kSigma = 1.5;
  constexpr double kContrast = 100;
  constexpr double kReach = 15;  // px beyond the rim
  const cv::Mat field = draw_field(texture, random);
  const double x0 = 0.5 * kWindow + random.uniform(-0.5, 0.5);
  const double y0 = 0.5 * kWindow + random.uniform(-0.5, 0.5);
  Problem problem;
  std::vector<float> rows;
  const double weight = 1 / (texture.white_sigma * texture.white_sigma);
  for (int y = 0; y < kWindow; ++y) {
    for (int x = 0; x < kWindow; ++x) {
      const double r = std::hypot(x - x0, y - y0);
      if (r > kRadius + kReach) continue;
      const double t = (kRadius - r) / kSigma;
      const double share = 0.5 * std::erfc(-t / std::numbers::sqrt2);
      const double slope =
          kContrast * std::exp(-0.5 * t * t) / (std::sqrt(2 * std::numbers::pi) * kSigma);
      Eigen::Matrix<double, kParameters, 1> row;
      row << slope * (x - x0) / std::max(r, 1e-6), slope * (y - y0) / std::max(r, 1e-6), slope, 1,
          share, -slope * t;
      const double residual =
          (1 - share) * field.at<double>(y, x) + texture.white_sigma * random.normal();
      if (t > 6) {  // sees no texture
        problem.information += weight * row * row.transpose();
        problem.gradient += weight * residual * row;
        continue;
      }
      problem.pixels.push_back({static_cast<float>(x),
                                static_cast<float>(y),
                                static_cast<float>(1 - share),
                                static_cast<float>(residual)});
      for (const double v : row) rows.push_back(static_cast<float>(v));
    }
  }
  problem.jacobian =
      Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          rows.data(), static_cast<Eigen::Index>(problem.pixels.size()), kParameters);
  return problem;
}

/// Step of least squares that take all noise for white.
Eigen::VectorXd plain_step(const Problem& problem, double white_sigma) {
  const double weight = 1 / (white_sigma * white_sigma);
  Eigen::VectorXd residual(problem.jacobian.rows());
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    residual[i] = static_cast<double>(problem.pixels[static_cast<std::size_t>(i)].residual);
  }
  const Eigen::MatrixXd j = problem.jacobian.cast<double>();
  const Eigen::MatrixXd h = weight * j.transpose() * j + problem.information;
  return h.ldlt().solve(weight * j.transpose() * residual + problem.gradient);
}

/// Errors of the centre over many draws; the truth is a step of 0.
struct Errors {
  double generalized = 0;  ///< mean squares of one coordinate
  double plain = 0;
  double predicted = 0;
  double chi_square = 0;  ///< mean
};

Errors errors_of(const Texture& texture, std::uint64_t seed) {
  constexpr int kDraws = 200;
  Errors errors;
  for (int i = 0; i < kDraws; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    const Problem problem = draw_problem(texture, random);
    const auto step = generalized_step(
        problem.pixels, problem.jacobian, texture, problem.information, problem.gradient);
    if (!step) {
      ADD_FAILURE() << "draw " << i;
      return errors;
    }
    const Eigen::VectorXd plain = plain_step(problem, texture.white_sigma);
    errors.generalized += step->step.head<2>().squaredNorm() / (2 * kDraws);
    errors.plain += plain.head<2>().squaredNorm() / (2 * kDraws);
    errors.predicted += (step->covariance(0, 0) + step->covariance(1, 1)) / (2 * kDraws);
    errors.chi_square += step->chi_square / kDraws;
  }
  return errors;
}

/// 200 draws of two numbers: one standard deviation of the ratio of rms is 0.035.
///
/// The lattice leaves out detail finer than 1.2 ranges, which strong texture shows.
void expect_honest(const Errors& errors) {
  const double ratio = std::sqrt(errors.generalized / errors.predicted);
  EXPECT_GT(ratio, 0.9);
  EXPECT_LT(ratio, 1.1);
  EXPECT_NEAR(errors.chi_square, 1, 0.15);
}

TEST(TextureFit, StepIsHonestAndBeatsPlainLeastSquares) {
  const Errors errors = errors_of({.sigma = 12, .range_px = 2.5, .white_sigma = 3}, 1);
  expect_honest(errors);
  EXPECT_GT(std::sqrt(errors.plain / errors.generalized), 1.5);
}

TEST(TextureFit, StepIsHonestOnCoarseTexture) {
  const Errors errors = errors_of({.sigma = 8, .range_px = 5, .white_sigma = 4}, 2);
  expect_honest(errors);
  EXPECT_LT(errors.generalized, errors.plain);
}

TEST(TextureFit, StepIsHonestOnFaintTexture) {
  expect_honest(errors_of({.sigma = 3, .range_px = 2.5, .white_sigma = 5}, 3));
}

TEST(TextureFit, HardlyAnyTextureIsPlainLeastSquares) {
  const Texture texture{.sigma = 1e-3, .range_px = 3, .white_sigma = 4};
  Random random(4);
  const Problem problem = draw_problem(texture, random);
  const auto step = generalized_step(
      problem.pixels, problem.jacobian, texture, problem.information, problem.gradient);
  ASSERT_TRUE(step.has_value());
  const Eigen::VectorXd plain = plain_step(problem, texture.white_sigma);
  constexpr double kFloat = 1e-3;  // of a standard deviation
  for (Eigen::Index i = 0; i < kParameters; ++i) {
    EXPECT_NEAR(step->step[i], plain[i], kFloat * std::sqrt(step->covariance(i, i))) << i;
  }
}

TEST(TextureFit, RefusesWhatCannotBeSolved) {
  const Texture texture{.sigma = 3, .range_px = 3, .white_sigma = 4};
  const Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2, 2);
  const Eigen::VectorXd g = Eigen::VectorXd::Zero(2);
  EXPECT_FALSE(generalized_step({}, Eigen::MatrixXf(0, 2), texture, h, g).has_value());
  // Nothing depends on the second parameter.
  const std::vector<TexturedPixel> pixels = {{0, 0, 1, 0.5F}, {4, 1, 1, -0.2F}, {9, 7, 0, 0.1F}};
  Eigen::MatrixXf jacobian = Eigen::MatrixXf::Zero(3, 2);
  jacobian.col(0).setOnes();
  EXPECT_FALSE(generalized_step(pixels, jacobian, texture, h, g).has_value());
}

/// Ground around a disc, as a window has it: 0 on the disc and beyond the window.
std::vector<float> draw_ground(const Texture& texture, Random& random, double& n) {
  const cv::Mat field = draw_field(texture, random);
  std::vector<float> values;
  n = 0;
  for (int y = 0; y < kWindow; ++y) {
    for (int x = 0; x < kWindow; ++x) {
      const double r = std::hypot(x - 63.5, y - 63.5);
      const double v = field.at<double>(y, x) + texture.white_sigma * random.normal();
      const bool is_ground = r > 36 && r < 64;
      values.push_back(is_ground ? static_cast<float>(v) : 0.0F);
      n += is_ground;
    }
  }
  return values;
}

TEST(TextureFit, FindsTheTexturesModel) {
  constexpr int kDraws = 100;
  constexpr double kTolerance = 0.2;  // of the mean over the draws
  for (const Texture& truth : {Texture{.sigma = 8, .range_px = 2.5, .white_sigma = 4},
                               Texture{.sigma = 5, .range_px = 4, .white_sigma = 5}}) {
    Texture mean{.sigma = 0, .range_px = 0, .white_sigma = 0};
    for (int i = 0; i < kDraws; ++i) {
      Random random = Random(5).fork(static_cast<std::uint64_t>(i));
      double n = 0;
      const std::vector<float> values = draw_ground(truth, random, n);
      const auto seen = texture_of({values, kWindow, n});
      ASSERT_TRUE(seen.has_value()) << "draw " << i;
      mean.sigma += seen->sigma / kDraws;
      mean.range_px += seen->range_px / kDraws;
      mean.white_sigma += seen->white_sigma / kDraws;
    }
    EXPECT_NEAR(mean.sigma, truth.sigma, kTolerance * truth.sigma);
    EXPECT_NEAR(mean.range_px, truth.range_px, kTolerance * truth.range_px);
    EXPECT_NEAR(mean.white_sigma, truth.white_sigma, kTolerance * truth.white_sigma);
  }
}

TEST(TextureFit, WhiteNoiseIsNearlyAllWhite) {
  constexpr int kDraws = 100;
  constexpr double kWhite = 4;
  for (int i = 0; i < kDraws; ++i) {
    Random random = Random(6).fork(static_cast<std::uint64_t>(i));
    double n = 0;
    const std::vector<float> values =
        draw_ground({.sigma = 0, .range_px = 3, .white_sigma = kWhite}, random, n);
    const auto seen = texture_of({values, kWindow, n});
    if (!seen) continue;
    // Six thousand pixels show a correlation of a few percent by chance.
    EXPECT_LT(seen->sigma, 0.25 * kWhite) << "draw " << i;
    EXPECT_NEAR(seen->white_sigma, kWhite, 0.1 * kWhite) << "draw " << i;
  }
}

TEST(TextureFit, FewPixelsHaveNoTexture) {
  const std::vector<float> values(64, 1.0F);
  EXPECT_FALSE(texture_of({values, 8, 64}).has_value());
}

}  // namespace
}  // namespace panelcal::internal
