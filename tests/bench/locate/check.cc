// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/check.h"

#include <cmath>
#include <numbers>
#include <string_view>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include "tests/bench/locate/bound.h"
#include "tests/bench/locate/texture.h"

namespace panelcal::bench {
namespace {

bool report(std::string_view what, double got, double expected, double tolerance) {
  const bool is_right = std::abs(got / expected - 1) <= tolerance;
  fmt::print("  {:<66}{:>10.6f}{:>10.6f}  {}\n", what, got, expected, is_right ? "ok" : "WRONG");
  return is_right;
}

const Condition& typical() {
  return conditions().at(1);
}

/// With nothing else unknown the integral over the rim has a closed form; the square of the edge's
/// slope integrates to C^2 / (2 sqrt(pi) s) a px, along a side of length a over a - 2 s / sqrt(pi)
/// px, as corners are blurred. A pixel's square is not quite a Gaussian, and a curved rim not quite
/// straight: 0.5 %.
bool check_closed_forms() {
  constexpr double kTolerance = 0.005;
  const Condition& c = typical();
  const auto centre_only = [&](const Mark& mark) {
    const Eigen::MatrixXd j = linearise(c, mark).jacobian.leftCols<2>();
    return c.noise / j.col(0).norm();
  };
  const double s = std::hypot(c.blur_px, std::sqrt(1.0 / 12));
  const double side_px = 80;
  const double root_pi = std::sqrt(std::numbers::pi);
  const double square = c.noise / c.contrast * std::sqrt(root_pi * s / (side_px - 2 * s / root_pi));
  const bool disc_ok = report("disc, only its centre unknown: closed form",
                              centre_only(make_mark(Shape::Disc, 40)),
                              closed_form_bound(c, 40),
                              kTolerance);
  const bool square_ok = report("square, only its centre unknown: closed form",
                                centre_only(make_mark(Shape::Square, side_px / 2)),
                                square,
                                kTolerance);
  return disc_ok && square_ok;
}

double x_bound(const Eigen::Matrix2d& cov) {
  return std::sqrt(cov(0, 0));
}

/// Texture without correlation is only more noise where the board is seen: weights do it.
bool check_white_texture() {
  const Condition& c = typical();
  const LinearModel model = linearise(c, make_mark(Shape::Disc, 40));
  constexpr double kSigma = 8;
  const Texture texture = Texture::white(kSigma, model.side_px - 1);
  const Eigen::ArrayXd variance =
      c.noise * c.noise + kSigma * kSigma * model.background_share.array().square();
  return report("uncorrelated texture: weighted white noise",
                x_bound(coloured_bound(model, c.noise, texture)),
                x_bound(white_bound(model, 1, variance.inverse().matrix())),
                1e-6);
}

/// Conjugate gradients with FFT against a dense factorisation, in a window where that is possible.
bool check_solver() {
  const Condition& c = typical();
  constexpr int kMarginPx = 8;
  const LinearModel model = linearise(c, make_mark(Shape::Disc, 8), {0.3, 0.1}, kMarginPx);
  const Texture texture(c, model.side_px - 1, 20, 5);
  const Eigen::Index n = model.value.size();
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto dx = static_cast<int>(i % model.side_px - k % model.side_px);
      const auto dy = static_cast<int>(i / model.side_px - k / model.side_px);
      covariance(i, k) =
          model.background_share[i] * model.background_share[k] * texture.covariance(dx, dy);
    }
  }
  covariance.diagonal().array() += c.noise * c.noise;
  const Eigen::MatrixXd fisher =
      model.jacobian.transpose() * covariance.llt().solve(model.jacobian);
  return report("weave in a small window: dense Cholesky",
                x_bound(coloured_bound(model, c.noise, texture)),
                std::sqrt(fisher.inverse()(0, 0)),
                1e-4);
}

/// The best linear estimate reaches the bound on real weave exactly if the texture's covariance is
/// right, whatever its distribution: its error is measured on pictures.
bool check_on_pictures(std::uint64_t seed) {
  constexpr int kPictures = 600;
  const Condition& c = typical();
  const Mark mark = make_mark(Shape::Disc, 40);
  const LinearModel model = linearise(c, mark);
  const Texture texture(c, model.side_px - 1, 150, 77);
  const Eigen::MatrixXd solved = solve_coloured(model, c.noise, texture);
  const Eigen::MatrixXd fisher = model.jacobian.transpose() * solved;
  const Eigen::MatrixXd estimator = fisher.fullPivLu().solve(solved.transpose()).topRows<2>();
  const Camera camera = make_camera(model.side_px, model.side_px, c.blur_px, c.noise);
  Condition even = c;
  even.light_gradient = 0;
  double squares = 0;
  for (int i = 0; i < kPictures; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    Scene scene = draw_background(even, mark.polarity, random);
    scene.weave.seed = static_cast<std::uint64_t>(i) + 1000;
    scene.features = features_of(
        mark, camera, Eigen::Vector2d::Constant(model.side_px / 2), mark_level(c, mark.polarity));
    const Image image = render(scene, camera, random);
    Eigen::VectorXd residual(model.value.size());
    Eigen::Index k = 0;
    for (const float v : image.pixels()) {
      residual[k] = static_cast<double>(v) - model.value[k];
      ++k;
    }
    squares += 0.5 * (estimator * residual).squaredNorm();
  }
  // 4 standard deviations of an rms of 2 n numbers.
  const double tolerance = 4 / std::sqrt(4.0 * kPictures);
  return report("weave: rmse of the best linear estimate on 600 pictures",
                std::sqrt(squares / kPictures),
                x_bound(coloured_bound(model, c.noise, texture)),
                tolerance);
}

}  // namespace

bool check_bounds(std::uint64_t seed) {
  fmt::print("\nchecks of the bounds, px:\n  {:<66}{:>10}{:>10}\n", "", "got", "expected");
  const bool closed_ok = check_closed_forms();
  const bool white_ok = check_white_texture();
  const bool solver_ok = check_solver();
  const bool pictures_ok = check_on_pictures(seed);
  return closed_ok && white_ok && solver_ok && pictures_ok;
}

}  // namespace panelcal::bench
