// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "calib/base/statistics/median.h"
#include "vision/fit/frame_patch.h"
#include "vision/fit/search_area.h"
#include "vision/polygon/quality.h"
#include "vision/polygon/solver.h"
#include "vision/polygon/texture.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr double kPolygonHuber = 2.0;
/// Steps that are the last ones, px: the error after them is some hundredths of them.
constexpr double kPolygonRough = 0.03;
constexpr double kFine = 2e-3;
/// Greatest move of a pattern after a fit, px.
constexpr double kSlackPx = 0.75;
/// Flat pixels farther than this from the outline are taken on a coarse lattice.
constexpr double kDensePx = 30;
constexpr int kStride = 4;
/// Debris on the outline is never left out to its last trace. Measured with a tenth of it covered,
/// errors are as if the variance were larger by this (tests/bench/README.md); neighbours that touch
/// the lines' feet exclude less of them than this part.
constexpr double kPolygonDebrisDoubt = 2.4;
constexpr double kCleanLines = 0.025;
/// Distance from the lines to which pixels count for the correlation, as part of the pattern's half
/// extent.
constexpr double kPolygonScoreReach = 0.25;

/// The pattern's extent and what is around it within reach.
struct Extent {
  Eigen::Vector2d low;
  Eigen::Vector2d high;

  /// Distance from the extent, pattern units; 0 inside.
  double outside(const Eigen::Vector2d& v) const {
    return (low - v).cwiseMax(v - high).cwiseMax(0.0).norm();
  }
};

double units_of(const CellState& state) {
  return std::sqrt(std::abs(state.jacobian(state.to_frame({0, 0})).determinant()));
}

/// Pixels (of the reduced picture) about the pattern; empty if the frame cannot be drawn there.
std::optional<PixelBox> polygon_box(const Image& image,
                                    const FitFrame& fit_frame,
                                    const CellState& state,
                                    const Extent& extent,
                                    double reach_units,
                                    const CellFitOptions& options) {
  const double k = options.reduction;
  const Eigen::Vector2d first(options.image_x0, options.image_y0);
  Eigen::Vector2d low(1e30, 1e30);
  Eigen::Vector2d high = -low;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(reach_units);
  const Eigen::Vector2d a = extent.low - margin;
  const Eigen::Vector2d b = extent.high + margin;
  for (const Eigen::Vector2d& v :
       {a, b, Eigen::Vector2d(a.x(), b.y()), Eigen::Vector2d(b.x(), a.y())}) {
    const auto u = fit_frame.to_image(state.to_frame(v));
    if (!u || !u->allFinite()) return std::nullopt;
    low = low.cwiseMin(*u - first);
    high = high.cwiseMax(*u - first);
  }
  const Eigen::Vector2d one = Eigen::Vector2d::Ones();
  const PixelBox box = pixels_between(low / k - one, high / k + one, image);
  if (box.width < 1 || box.height < 1) return std::nullopt;
  return box;
}

std::vector<CellPixel> collect(const Image& image,
                               const FitFrame& fit_frame,
                               const CellModel& model,
                               const CellState& start,
                               const CellFitOptions& options) {
  const CellPattern& pattern = model.pattern();
  const Extent extent{{pattern.x.front(), pattern.y.front()}, {pattern.x.back(), pattern.y.back()}};
  const double units = units_of(start);
  const double reach = options.reach * units;
  std::vector<CellPixel> pixels;
  const auto box = polygon_box(image, fit_frame, start, extent, reach, options);
  if (!box) return pixels;
  const double k = options.reduction;
  const Eigen::Vector2d first =
      Eigen::Vector2d(options.image_x0, options.image_y0).array() + 0.5 * (k - 1);
  const Eigen::Vector2d middle =
      first + k * Eigen::Vector2d(box->x0 + 0.5 * box->width, box->y0 + 0.5 * box->height);
  const FramePatch patch(fit_frame, middle, 0.5 * k * std::max(box->width, box->height) + 1);
  pixels.reserve(static_cast<std::size_t>(box->width) * static_cast<std::size_t>(box->height));
  const double dense = kDensePx * units;
  for (int y = box->y0; y < box->y0 + box->height; y += options.stride) {
    const FramePatch::Row row = patch.row(y);
    for (int x = box->x0; x < box->x0 + box->width; x += options.stride) {
      // Reduced pixels are few: the exact frame does.
      const Eigen::Vector2d u = first + k * Eigen::Vector2d(x, y);
      CellPixel pixel;
      if (fit_frame.mapping()) {
        const FramePatch::Row::At at =
            options.reduction == 1
                ? row.at(x)
                : FramePatch::Row::At{fit_frame.from_image(u), fit_frame.jacobian(u)};
        pixel.at = at.place;
        pixel.jacobian = k * at.jacobian;
      } else {
        pixel.at = fit_frame.from_image(u);
        pixel.jacobian = k * Eigen::Matrix2d::Identity();
      }
      const Eigen::Vector2d v = start.to_pattern(pixel.at);
      const double outside = extent.outside(v);
      if (outside > reach || (outside > dense && (x % kStride != 0 || y % kStride != 0))) continue;
      pixel.value = image.at(x, y);
      pixel.x = x;
      pixel.y = y;
      pixels.push_back(pixel);
    }
  }
  return pixels;
}

/// Marks the pixels that see no line while those move by up to slack. `only_near`: those that saw
/// none before still see none.
void classify(const CellModel& model,
              const CellState& state,
              double slack_px,
              bool only_near,
              std::vector<CellPixel>& pixels) {
  CellView view(model, state);
  for (CellPixel& pixel : pixels) {
    if (only_near && pixel.is_flat) continue;
    const auto share = view.flat_share(pixel, slack_px);
    pixel.is_flat = share.has_value();
    pixel.share = static_cast<float>(share.value_or(0));
  }
}

/// Levels of background and target from the pixels that are almost flat; false if there are none.
bool guess_levels(const CellModel& model, const std::vector<CellPixel>& pixels, CellState& state) {
  constexpr std::array kShares = {0.0, 0.02, 0.1, 0.25, 0.4};
  constexpr std::size_t kEnough = 30;
  constexpr std::size_t kSample = 3;            // of the flat pixels
  std::vector<std::pair<double, double>> seen;  // share, value
  seen.reserve(pixels.size());
  CellView view(model, state);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const CellPixel& pixel = pixels[i];
    if (pixel.is_flat) {
      if (i % kSample == 0) seen.emplace_back(pixel.share, pixel.value);
      continue;
    }
    const auto value = view.evaluate(pixel, nullptr);
    if (value.is_known) seen.emplace_back(value.share, pixel.value);
  }
  std::vector<double> low;
  std::vector<double> high;
  for (const double share : kShares) {
    low.clear();
    high.clear();
    for (const auto& [s, value] : seen) {
      if (s <= share) low.push_back(value);
      if (s >= 1 - share) high.push_back(value);
    }
    if (low.size() >= kEnough && high.size() >= kEnough) break;
  }
  constexpr std::size_t kLeast = 4;
  if (low.size() < kLeast || high.size() < kLeast) return false;
  const double background = median(std::move(low));
  state.levels << background, 0, 0, median(std::move(high)) - background, 0, 0;
  return true;
}

/// Leaves out flat pixels that cannot be what they should be, before anything is fitted.
void exclude_outliers(const CellState& state, double white_noise, std::vector<CellPixel>& pixels) {
  constexpr double kOfContrast = 0.35;  // light may change that much across a window
  const double limit = std::max(kOfContrast * std::abs(state.levels[3]), 6 * white_noise);
  for (CellPixel& pixel : pixels) {
    if (!pixel.is_flat) continue;
    pixel.is_excluded =
        std::abs(pixel.value - state.levels[0] - pixel.share * state.levels[3]) > limit;
  }
}

/// Greatest move of the pattern's corners from one state to another, pattern units.
double corner_move(const CellPattern& pattern, const CellState& from, const CellState& to) {
  double move = 0;
  for (const double x : {pattern.x.front(), pattern.x.back()}) {
    for (const double y : {pattern.y.front(), pattern.y.back()}) {
      const Eigen::Vector2d v(x, y);
      move = std::max(move, (to.to_pattern(from.to_frame(v)) - v).norm());
    }
  }
  return move;
}

/// True if a fit left the pattern that it was started at: there is none.
bool is_polygon_astray(const CellModel& model, const CellState& state, const CellState& start) {
  constexpr double kFar = 0.35;  // of the half extent
  if (!state.pattern_from_frame.allFinite() || !state.levels.allFinite()) return true;
  const double limit = kFar * half_extent(model.pattern()) + 2 * units_of(start);
  return !(corner_move(model.pattern(), start, state) < limit);
}

void set_quality(const CellModel& model, double full_scale, double white_noise, CellFit& fit) {
  const CellNoise noise = noise_of(model, fit.pixels, fit.state, full_scale);
  fit.noise_outside = noise.outside;
  fit.noise_inside = noise.inside;
  fit.rim_noise = noise.rim;
  fit.rim_excess = noise.rim_excess;
  const double reach_px =
      std::max(3 * fit.state.sigma_px,
               kPolygonScoreReach * half_extent(model.pattern()) / units_of(fit.state));
  fit.correlation = correlation_near(model, fit.state, fit.pixels, white_noise, reach_px);
  const OutlineSeen seen = outline_seen(model, fit.state, fit.pixels, noise);
  fit.visible = seen.visible;
  fit.outside_picture = seen.outside_picture;
  fit.weakest_side = seen.weakest_side;
  fit.evenness = seen.evenness;
  fit.intact = intact_part(model, fit.state, fit.pixels);
  int n_near = 0;
  int n_clipped = 0;
  for (const CellPixel& pixel : fit.pixels) {
    if (pixel.is_flat) continue;
    ++n_near;
    n_clipped += pixel.value >= full_scale || pixel.value <= 0;
  }
  fit.clipped = n_near > 0 ? static_cast<double>(n_clipped) / n_near : 0;
}

void set_covariance(const CellModel& model,
                    const CellSolution& solution,
                    bool is_blind_along_x,
                    CellFit& fit) {
  const int n = model.n_parameters();
  Eigen::MatrixXd h = solution.information.topLeftCorner(n, n);
  if (is_blind_along_x) {
    h.row(0).setZero();
    h.col(0).setZero();
    h(0, 0) = 1;
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(h);
  if (factor.info() != Eigen::Success || !factor.isPositive()) {
    fit.converged = false;
    return;
  }
  fit.cov.topLeftCorner(n, n) = fit.rim_excess * factor.solve(Eigen::MatrixXd::Identity(n, n));
  if (!fit.cov.allFinite()) fit.converged = false;
}

}  // namespace

CellFit fit_cells(const Image& image,
                  const FitFrame& fit_frame,
                  const CellModel& model,
                  const CellState& start,
                  const CellFitOptions& options) {
  CellFit fit;
  fit.state = start;
  fit.pixels = collect(image, fit_frame, model, start, options);
  const double slack_px = options.start_error / options.reduction;
  classify(model, start, slack_px, false, fit.pixels);
  if (!options.is_refined && !guess_levels(model, fit.pixels, fit.state)) return fit;
  const double white_noise =
      white_noise_of(fit.pixels, [&](std::size_t i) { return fit.pixels[i].value; });
  // The start's residuals are mostly misplacement, so Huber's limit is a generous guess.
  const double guess = std::max(1.0, 0.1 * std::abs(fit.state.levels[3]));
  for (CellPixel& pixel : fit.pixels) pixel.weight = 1 / (guess * guess);

  CellSolverOptions solver{.full_scale = image.full_scale(),
                           .huber = kPolygonHuber,
                           .tolerance_px = kPolygonRough,
                           .max_sigma_px = options.max_sigma_px};
  CellSolution solution;
  if (!options.is_refined) {
    exclude_outliers(fit.state, white_noise, fit.pixels);
    solution = solve_cells(model, fit.pixels, fit.state, solver);
    fit.state = solution.state;
    fit.converged = solution.converged && !is_polygon_astray(model, solution.state, start);
    if (!fit.converged || options.is_rough) return fit;
  }

  const double move_px = corner_move(model.pattern(), start, fit.state) / units_of(start);
  const bool was_wide = move_px + kSlackPx < slack_px && fit.state.sigma_px <= start.sigma_px;
  classify(model, fit.state, kSlackPx, was_wide, fit.pixels);
  solver.huber = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const double before = fit.excluded;
    fit.excluded = exclude_strangers(model, fit.state, image.full_scale(), fit.pixels);
    if (before == 0 && fit.excluded == 0) break;
    solution = solve_cells(model, fit.pixels, fit.state, solver);
    fit.state = solution.state;
  }
  set_weights(
      model, fit.state, noise_of(model, fit.pixels, fit.state, image.full_scale()), fit.pixels);
  solver.tolerance_px = kFine;
  solution = solve_cells(model, fit.pixels, fit.state, solver);
  fit.state = solution.state;
  fit.converged = solution.converged && !is_polygon_astray(model, solution.state, start);
  set_quality(model, image.full_scale(), white_noise, fit);
  set_covariance(model, solution, options.is_blind_along_x, fit);
  if (fit.converged && options.may_be_textured) {
    refit_on_texture(model, image.full_scale(), options.is_blind_along_x, fit);
  }
  if (fit.excluded > kCleanLines) fit.cov *= kPolygonDebrisDoubt;
  return fit;
}

CellPlace place_of(const CellModel& model, const CellFit& fit, const Eigen::Vector2d& v) {
  const Eigen::Matrix<double, 2, kMaxCellParameters> j = model.place_gradient(fit.state, v);
  return {fit.state.to_frame(v), j * fit.cov * j.transpose()};
}

}  // namespace panelcal::internal
