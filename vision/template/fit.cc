// SPDX-License-Identifier: Apache-2.0
#include "vision/template/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calib/base/statistics/median.h"
#include "vision/fit/raster_filter.h"
#include "vision/fit/regression.h"
#include "vision/fit/residual.h"
#include "vision/template/covariance.h"
#include "vision/template/solver.h"

namespace panelcal::internal {
namespace {

constexpr double kTemplateHuber = 2.0;
constexpr double kTemplateRough = 0.01;  // px
constexpr double kOfLevel = 0.1;         // px of a coarse level: better does not help the next one
constexpr int kMinPixels = 40;

/// Pixel minus model (with the smooth template) and how much half a px of displacement would do.
struct Residuals {
  std::vector<double> value;
  std::vector<double> slope;  ///< grey levels per px
  double sigma = 0;           ///< robust
};

Residuals residuals_of(const TemplateProblem& problem, const TemplateVector& p) {
  const TemplateMap map(problem.model, p);
  Residuals out;
  std::vector<double> magnitudes;
  for (const TemplatePixel& pixel : problem.window.pixels) {
    const auto value = evaluate(problem.model, problem.window, map, pixel, p, false);
    const bool counts =
        value && !is_beyond_scale(pixel.value, value->smooth_level, problem.full_scale);
    out.value.push_back(counts ? pixel.value - value->smooth_level : 0);
    out.slope.push_back(counts ? value->slope.norm() / problem.model.pitch : 0);
    if (counts) magnitudes.push_back(std::abs(out.value.back()));
  }
  out.sigma = kSigmasPerMedian * median(std::move(magnitudes));
  return out;
}

/// The window's values as rows of the picture, 0 where there are none.
Raster spread(const TemplateWindow& window, const std::vector<double>& values) {
  Raster raster(window.width, window.height);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const TemplatePixel& pixel = window.pixels[i];
    raster.at(pixel.x - window.x0, pixel.y - window.y0) = values[i];
  }
  return raster;
}

/// Sets is_excluded on what the model cannot explain, also where only the mean over some pixels
/// shows it, and on its surroundings. Returns how many are excluded, as part of all.
double exclude_strangers(TemplateProblem& problem, const TemplateVector& p) {
  constexpr double kSigmas = 6;
  constexpr double kStrangerContrast = 0.15;
  constexpr double kMeanOfContrast = 0.06;
  constexpr double kShiftPx = 0.7;  // an edge that is off by this is still an edge
  constexpr double kMeanPx = 1.5;   // sigma of the local mean, of 28 pixels' worth
  constexpr double kMeanPixels = 4 * 3.14159 * kMeanPx * kMeanPx;
  constexpr int kGrow = 2;

  TemplateWindow& window = problem.window;
  const Residuals r = residuals_of(problem, p);
  const double sigma = std::max(0.3, r.sigma);
  const double contrast = std::abs(p[kGain]);
  const Raster mean = blurred(spread(window, r.value), kMeanPx);
  const Raster mean_slope = blurred(spread(window, r.slope), kMeanPx);
  Raster grown(window.width, window.height);
  for (std::size_t i = 0; i < r.value.size(); ++i) {
    const int x = window.pixels[i].x - window.x0;
    const int y = window.pixels[i].y - window.y0;
    const double limit =
        std::max(kSigmas * sigma, kStrangerContrast * contrast + kShiftPx * r.slope[i]);
    const double mean_limit = std::max(kSigmas * sigma / std::sqrt(kMeanPixels),
                                       kMeanOfContrast * contrast + kShiftPx * mean_slope.at(x, y));
    if (std::abs(r.value[i]) <= limit && std::abs(mean.at(x, y)) <= mean_limit) continue;
    for (int dy = std::max(0, y - kGrow); dy <= std::min(window.height - 1, y + kGrow); ++dy) {
      for (int dx = std::max(0, x - kGrow); dx <= std::min(window.width - 1, x + kGrow); ++dx) {
        grown.at(dx, dy) = 1;
      }
    }
  }
  double n_excluded = 0;
  for (TemplatePixel& pixel : window.pixels) {
    pixel.is_excluded = grown.at(pixel.x - window.x0, pixel.y - window.y0) != 0;
    n_excluded += pixel.is_excluded;
  }
  return n_excluded / std::max<double>(1, static_cast<double>(window.pixels.size()));
}

void set_weights(TemplateWindow& window, double sigma) {
  for (TemplatePixel& pixel : window.pixels) pixel.weight = 1 / (sigma * sigma);
}

/// Agreement of picture and model: over all pixels and by parts of the template.
struct Agreement {
  double correlation = 0;
  double visible = 0;
  double clipped = 0;
};

/// A part of the template.
struct Tile {
  Regression levels;       ///< without what is excluded
  double energy = 0;       ///< of the edges
  double kept_energy = 0;  ///< of those that are not excluded
};

/// True if what is not excluded of a part looks as the whole says it should.
bool agrees(const Regression& part, double noise) {
  constexpr double kLowGain = 0.4;
  constexpr double kHighGain = 1.6;
  constexpr double kUnexplained = 0.35;
  constexpr double kFewPixels = 10;
  if (part.n < kFewPixels || !(part.model_square() > 0)) return false;
  const double gain = part.gain();
  const double gain_sigma = noise / std::sqrt(part.model_square());
  if (gain < kLowGain - 3 * gain_sigma || gain > kHighGain + 3 * gain_sigma) return false;
  const double square =
      part.seen_square() - 2 * part.product() + part.model_square();  // of the residuals
  const double variance = noise * noise;
  const double by_chance = variance * (part.n + 4 * std::sqrt(2 * part.n));
  return square - by_chance < kUnexplained * part.model_square();
}

Agreement agreement_of(const TemplateProblem& problem,
                       const TemplateVector& p,
                       const TemplateNoise& noise) {
  constexpr int kTiles = 4;
  constexpr double kTileShare = 0.01;  // tiles with less of the edges do not tell anything
  const TemplateMap map(problem.model, p);
  std::array<Tile, kTiles * kTiles> tiles;
  Regression all;
  double all_energy = 0;
  Agreement out;
  for (const TemplatePixel& pixel : problem.window.pixels) {
    const auto value = evaluate(problem.model, problem.window, map, pixel, p, false);
    if (!value) continue;
    const double plane = pixel.plane.dot(p.segment<3>(kLevel));
    const double model = std::clamp(value->smooth_level, 0.0, problem.full_scale) - plane;
    const double seen = pixel.value - plane;
    const auto tile = [&](double at, int size) {
      return static_cast<std::size_t>(
          std::clamp(static_cast<int>(kTiles * (at + 0.5) / size), 0, kTiles - 1));
    };
    Tile& part = tiles[tile(value->at.y(), problem.model.height()) * kTiles +
                       tile(value->at.x(), problem.model.width())];
    const double edge = value->slope.squaredNorm();
    all.add(model, seen);
    all_energy += edge;
    part.energy += edge;
    if (!pixel.is_excluded) {
      part.kept_energy += edge;
      part.levels.add(model, seen);
    }
    out.clipped += pixel.value >= problem.full_scale || pixel.value <= 0;
  }
  out.clipped /= std::max(1.0, all.n);
  double energy = 0;
  double agreeing = 0;
  for (const Tile& part : tiles) {
    if (part.energy < kTileShare * all_energy) continue;
    energy += part.energy;
    if (agrees(part.levels, noise.all)) agreeing += part.kept_energy;
  }
  out.visible = energy > 0 ? agreeing / energy : 0;
  // The model is smooth: only the picture's noise is to be taken off.
  out.correlation = all.correlation(noise.picture * noise.picture);
  return out;
}

/// From coarse to fine without the last level. False if it got lost.
bool approach(const Image& image,
              const FitFrame& fit_frame,
              TemplateProblem& problem,
              int level,
              TemplateVector& p) {
  for (; level > 0; --level) {
    problem.window = make_template_window(image, fit_frame, problem.model, p, level);
    if (problem.window.pixels.size() < kMinPixels) continue;
    set_weights(problem.window, 1);
    solve_levels(problem, p);
    set_weights(problem.window, std::max(1.0, 0.15 * std::abs(p[kGain])));
    // A level that does not converge is not the last word: the next one sees more.
    minimise(problem, kGain + 1, kTemplateHuber, kOfLevel * (1 << level), p);
    if (!p.allFinite()) return false;
  }
  return true;
}

}  // namespace

TemplateFit fit_template(const Image& image,
                         const FitFrame& fit_frame,
                         const TemplateModel& model,
                         const TemplateVector& start,
                         int level,
                         const TemplatePrior& prior,
                         double gain_sign) {
  TemplateFit fit;
  TemplateProblem problem{model, {}, prior, image.full_scale()};
  TemplateVector& p = fit.parameters;
  p = start;
  level = std::min(level, static_cast<int>(model.reduced.size()));
  const double far = 3.0 * (1 << level) + 2;
  const auto is_lost = [&] {
    return !p.allFinite() || (p.head<2>() - start.head<2>()).norm() > far ||
           !(gain_sign * p[kGain] > 0);
  };
  if (!approach(image, fit_frame, problem, level, p)) return fit;

  const auto look_again = [&] {
    problem.window = make_template_window(image, fit_frame, model, p, 0);
    fit.seen_share = problem.window.seen_share;
    return problem.window.pixels.size() >= kMinPixels;
  };
  if (!look_again()) return fit;
  set_weights(problem.window, 1);
  p[kFocus] = 0;
  solve_levels(problem, p);
  if (is_lost()) return fit;
  set_weights(problem.window, std::max(1.0, 0.1 * std::abs(p[kGain])));
  minimise(problem, kTemplateParameters, kTemplateHuber, kTemplateRough, p);
  if (is_lost()) return fit;
  for (int pass = 0; pass < 2; ++pass) {
    const TemplateVector kept = p;
    if (!look_again()) return fit;
    fit.excluded = exclude_strangers(problem, kept);
    set_weights(problem.window, std::max(1.0, 0.1 * std::abs(p[kGain])));
    minimise(problem, kTemplateParameters, 0, kTemplateRough, p);
    if (is_lost()) return fit;
  }
  const Residuals residuals = residuals_of(problem, p);
  const double white_noise =
      white_noise_of(problem.window.pixels, [&](std::size_t i) { return residuals.value[i]; });
  set_weights(problem.window, template_noise(problem, p, white_noise).all);
  fit.converged = solve_with_smooth_rows(problem, p) && !is_lost();
  const TemplateNoise noise = template_noise(problem, p, white_noise);
  set_weights(problem.window, noise.all);
  const Agreement agreement = agreement_of(problem, p, noise);
  fit.noise = noise.all;
  fit.picture_noise = noise.picture;
  fit.correlation = agreement.correlation;
  fit.visible = agreement.visible;
  fit.clipped = agreement.clipped;
  if (fit.converged) fit.cov = template_covariance(problem, p, noise);
  return fit;
}

}  // namespace panelcal::internal
