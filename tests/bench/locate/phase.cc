// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "tests/bench/locate/methods.h"

namespace panelcal::bench {
namespace {

constexpr int kPhases = 8;  ///< a grid of 8 x 8 sub-pixel places

/// Largest and mean error over the grid, px, at next to no noise in 16 bit: what is left is the
/// method's own.
void print_row(const Mark& mark, Random& random) {
  Condition condition = conditions().front();
  condition.noise = 0.02;
  const int side = 2 * static_cast<int>(std::ceil(mark.radius_px)) + 121;
  double largest = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int n_found = 0;
  std::string reason;
  for (int k = 0; k < kPhases * kPhases; ++k) {
    const Camera camera =
        make_camera(side, side, condition.blur_px, condition.noise * 257, Image::kFullScale16);
    const Eigen::Vector2d center_px =
        Eigen::Vector2d::Constant(side / 2) +
        Eigen::Vector2d(k % kPhases + 0.5, k / kPhases + 0.5) / kPhases;
    Scene scene;
    scene.background = background_level(condition, mark.polarity);
    scene.features = features_of(mark, camera, center_px, mark_level(condition, mark.polarity));
    const Image image = render(scene, camera, random);
    const Answer answer = locate_answer({image, mark, condition, center_px});
    if (!answer.is_found) {
      reason = answer.reason;
      continue;
    }
    ++n_found;
    const Eigen::Vector2d e = answer.center_px - center_px;
    sum += e;
    largest = std::max(largest, e.cwiseAbs().maxCoeff());
  }
  const Eigen::Vector2d mean = sum / std::max(1, n_found);
  fmt::print("  {:>5}{:>5}/{}{:>11.6f}{:>11.6f}{:>11.6f}  {}\n",
             mark.radius_px,
             n_found,
             kPhases * kPhases,
             largest,
             mean.x(),
             mean.y(),
             reason);
}

/// At the noise of "clean", in 8 bit: amplitude of the error's part that goes with the sub-pixel
/// place, sin and cos of 2 pi x fitted to many random places, beside what chance alone would give.
void print_noisy_row(const Mark& mark, int n, std::uint64_t seed) {
  const Condition& condition = conditions().front();
  const int side = 2 * static_cast<int>(std::ceil(mark.radius_px)) + 121;
  Eigen::Vector2d sines = Eigen::Vector2d::Zero();
  Eigen::Vector2d cosines = Eigen::Vector2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  int n_found = 0;
  for (int i = 0; i < n; ++i) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(i));
    const Sample sample = draw_sample(condition, mark, side, side, random);
    const Answer answer = locate_answer({sample.image, mark, condition, sample.center_px});
    if (!answer.is_found) continue;
    ++n_found;
    const Eigen::Vector2d e = answer.center_px - sample.center_px;
    const Eigen::Array2d phase = 2 * std::numbers::pi * sample.center_px.array();
    sines += e.cwiseProduct(phase.sin().matrix());
    cosines += e.cwiseProduct(phase.cos().matrix());
    sum += e;
    squares += 0.5 * e.squaredNorm();
  }
  const double found = std::max(1, n_found);
  const Eigen::Vector2d amplitude =
      (2 / found) * (sines.cwiseAbs2() + cosines.cwiseAbs2()).cwiseSqrt();
  // The mean length of a vector of two normal numbers is sqrt(pi / 2) sigma.
  const double by_chance =
      std::sqrt(std::numbers::pi / 2) * std::sqrt(squares / found) * std::sqrt(2 / found);
  fmt::print("  {:>5}{:>6}/{}{:>11.6f}{:>11.6f}{:>11.6f}{:>11.6f}{:>11.6f}\n",
             mark.radius_px,
             n_found,
             n,
             amplitude.x(),
             amplitude.y(),
             by_chance,
             sum.x() / found,
             sum.y() / found);
}

}  // namespace

void print_phase_bias(Shape shape, std::uint64_t seed) {
  fmt::print(
      "\npixel phase: 8 x 8 sub-pixel places, contrast 140, blur 1, noise 0.02, 16 bit; px\n");
  fmt::print("  {:>5}{:>8}{:>11}{:>11}{:>11}\n", "r", "found", "largest", "mean x", "mean y");
  Random random(seed);
  for (const double radius_px : {5, 10, 20, 40, 80, 160}) {
    print_row(make_mark(shape, radius_px), random);
  }
  fmt::print("pixel phase in clean as it is (8 bit, noise 2): first harmonic over random places\n");
  fmt::print("  {:>5}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}\n",
             "r",
             "found",
             "x",
             "y",
             "by chance",
             "mean x",
             "mean y");
  print_noisy_row(make_mark(shape, 5), 2000, seed);
  print_noisy_row(make_mark(shape, 10), 1000, seed);
  print_noisy_row(make_mark(shape, 20), 400, seed);
}

}  // namespace panelcal::bench