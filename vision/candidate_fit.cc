// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/candidate_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "panelcal/vision/fit_covariance.h"
#include "panelcal/vision/fit_window.h"
#include "panelcal/vision/rim_fit.h"

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

constexpr double kHuber = 2.0;
/// Steps at which fits stop, px: convergence is quadratic, so what is left is far smaller.
constexpr double kRough = 0.01;
constexpr double kFine = 1e-5;
/// Correlations below these parts of the score asked for are not worth a fit, or a second fit.
constexpr double kHopelessStart = 0.6;
constexpr double kHopelessFit = 0.85;
/// Width of the narrow band around the rim.
constexpr double kNarrowSigmas = 2.5;
constexpr double kNarrowPx = 2;
/// Around the target up to this part of its radius counts for the score, about as many pixels as
/// on it.
constexpr double kScoreReach = 0.35;
constexpr double kMinRadiusPx = 3;

/// Correlation of model and picture over the target and its near surroundings. What was excluded
/// as debris on the target counts, neighbours do not, nor does camera noise: a faint target may
/// look just like the model.
double correlation(const RimProblem& problem, double white_noise, const RimVector& p) {
  double n = 0;
  double sum_m = 0;
  double sum_v = 0;
  double sum_mm = 0;
  double sum_mv = 0;
  double sum_vv = 0;
  for (const WindowPixel& pixel : problem.window.pixels) {
    const auto value = problem.model.evaluate(pixel, p, nullptr);
    if (value.distance_px < -kScoreReach * p[kRadius]) continue;
    if (pixel.is_excluded && value.distance_px < -2 * p[kSigma]) continue;
    const double plane = value.plane.dot(p.segment<3>(kPlane));
    const double m = value.level - plane;
    const double v = pixel.value - plane;
    ++n;
    sum_m += m;
    sum_v += v;
    sum_mm += m * m;
    sum_mv += m * v;
    sum_vv += v * v;
  }
  const double var_m = n * sum_mm - sum_m * sum_m;
  const double var_seen = n * sum_vv - sum_v * sum_v;
  const double var_v = std::max(var_seen - n * n * white_noise * white_noise, 0.25 * var_seen);
  if (!(var_m > 0) || !(var_v > 0)) return 0;
  return std::clamp((n * sum_mv - sum_m * sum_v) / std::sqrt(var_m * var_v), 0.0, 1.0);
}

struct Estimate {
  RimSolution solution;
  double correlation = 0;
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
  double rim_noise = 0;
  double excluded = 0;
};

/// On texture the far background says little about the plane at the rim and much about the weave:
/// a fit to the rim's near surroundings is tried, and taken if its covariance is smaller.
void try_narrow_band(RimProblem& problem, const ResidualCorrelation& noise, Estimate& e) {
  const RimVector& p = e.solution.parameters;
  for (WindowPixel& pixel : problem.window.pixels) {
    const auto value = problem.model.evaluate(pixel, p, nullptr);
    if (value.distance_px < -kNarrowSigmas * p[kSigma] - kNarrowPx) pixel.in_fit = false;
  }
  const RimSolution narrow = fit_rim(problem, p, 0, kFine);
  if (!narrow.converged) return;
  const Eigen::Matrix2d cov = center_covariance(problem, narrow, noise);
  if (!cov.allFinite() || cov.trace() >= e.cov.trace()) return;
  e.solution = narrow;
  e.cov = cov;
}

/// True if a fit left the rim it was started at: there is none.
bool is_astray(const RimVector& p, const RimVector& start) {
  constexpr double kFar = 0.2;  // of the radius
  const double limit = std::max(1.0, kFar * start[kRadius]);
  return !p.allFinite() || (p.head<2>() - start.head<2>()).norm() > limit ||
         std::abs(p[kRadius] - start[kRadius]) > limit;
}

Estimate estimate(RimProblem& problem, const RimStart& start, double min_score) {
  Estimate e;
  const double white_noise = white_noise_of(problem.window);
  e.solution.parameters = start.parameters;
  e.correlation = correlation(problem, white_noise, start.parameters);
  if (e.correlation < kHopelessStart * min_score) return e;
  // The start's residuals are mostly misplacement, so noise for Huber's limit comes from the
  // flat pixels, after a fit with a generous guess.
  const double contrast = std::abs(start.parameters[kContrast]);
  const double guess = std::max(1.0, 0.1 * contrast);
  set_weights(problem, start.parameters, {guess, guess});
  e.solution = fit_rim(problem, start.parameters, kHuber, kRough);
  e.correlation = correlation(problem, white_noise, e.solution.parameters);
  if (is_astray(e.solution.parameters, start.parameters) ||
      e.correlation < kHopelessFit * min_score) {
    e.solution.converged = false;
  }
  if (!e.solution.converged) return e;
  for (int pass = 0; pass < 2; ++pass) {
    const bool was_clean = pass > 0 && e.excluded == 0;
    e.excluded = exclude_strangers(problem, e.solution.parameters);
    if (was_clean && e.excluded == 0) break;
    e.solution = fit_rim(problem, e.solution.parameters, 0, kRough);
  }
  set_weights(problem, e.solution.parameters, noise_of(problem, e.solution.parameters));
  e.solution = fit_rim(problem, e.solution.parameters, 0, kFine);
  const ResidualCorrelation noise = residual_correlation(problem, e.solution);
  e.rim_noise = noise.rim_noise;
  e.cov = center_covariance(problem, e.solution, noise);
  if (noise.outside.is_textured) try_narrow_band(problem, noise, e);
  e.correlation = correlation(problem, white_noise, e.solution.parameters);
  return e;
}

/// Center, sizes and covariance in the units of the outside world.
void fill_geometry(const FitFrame& fit_frame,
                   const ExpectedRim& expected,
                   const RimVector& p,
                   const Eigen::Matrix2d& cov,
                   TargetFit& fit) {
  const Eigen::Vector2d center = p.head<2>();
  const Eigen::Vector2d u = fit_frame.to_image(center).value_or(Eigen::Vector2d::Zero());
  const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(u).inverse();
  fit.center = {position_px<frame::Image>(u), propagate(px_from_frame, cov)};
  // The mean of a rim's diameters in the picture.
  const double px_per_unit = std::sqrt(std::abs(px_from_frame.determinant()));
  fit.size = px(2 * p[kRadius] * px_per_unit);
  if (expected.shape == Shape::Ring) fit.inner_size = px(2 * p[kInnerRadius] * px_per_unit);
  if (fit_frame.mapping()) {
    const double unit_mm = fit_frame.unit();
    fit.center_optical =
        PositionEstimate<frame::Optical>{fit_frame.to_optical(center), unit_mm * unit_mm * cov};
    fit.size_mm = mm(2 * p[kRadius] * unit_mm);
  }
}

std::optional<std::string> size_problem(
    const FitFrame& fit_frame, std::string_view what, double seen, double asked, double tolerance) {
  const double deviation = seen / asked - 1;
  if (std::abs(deviation) <= tolerance) return std::nullopt;
  const bool in_mm = fit_frame.mapping() != nullptr;
  const double unit = fit_frame.unit();
  return fmt::format("{} is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     what,
                     2 * seen * unit,
                     in_mm ? "mm" : "px",
                     100 * deviation,
                     2 * asked * unit,
                     100 * tolerance);
}

std::optional<std::string> unfit_reason(const FitFrame& fit_frame,
                                        const ExpectedRim& expected,
                                        const RimVector& p) {
  if (auto reason = size_problem(
          fit_frame, "its size", p[kRadius], expected.radius, expected.size_tolerance)) {
    return reason;
  }
  if (!expected.inner_radius) return std::nullopt;
  // Relative to the outer size: a thin pin hole's own diameter would be an unfair measure.
  const double tolerance = expected.size_tolerance * expected.radius / *expected.inner_radius;
  return size_problem(
      fit_frame, "its inner size", p[kInnerRadius], *expected.inner_radius, tolerance);
}

void judge(const Image& image,
           const FitFrame& fit_frame,
           const ExpectedRim& expected,
           const LocateOptions& options,
           const Estimate& e,
           FittedCandidate& candidate) {
  const RimVector& p = e.solution.parameters;
  const double contrast = p[kContrast] * expected.sign();
  const double min_contrast = options.min_contrast * image.full_scale();
  const auto set = [&](Verdict verdict, std::string reason) {
    candidate.verdict = verdict;
    candidate.reason = std::move(reason);
  };
  if (!e.solution.converged || !candidate.fit.center.cov.allFinite()) {
    return set(Verdict::Unlikely, "it does not look like the target");
  }
  if (contrast < min_contrast) {
    return set(Verdict::Unlikely,
               fmt::format("its contrast is {:.1f} grey levels, at least {:.1f} are asked for",
                           contrast,
                           min_contrast));
  }
  if (candidate.fit.score < options.min_score) {
    return set(Verdict::Unlikely,
               fmt::format("its score is {:.2f}, at least {:.2f} is asked for",
                           candidate.fit.score,
                           options.min_score));
  }
  if (auto reason = unfit_reason(fit_frame, expected, p)) {
    return set(Verdict::Unfit, *std::move(reason));
  }
  set(Verdict::Good, "");
}

/// A rim that leaves the picture is not fitted: what is missing would be guessed.
FittedCandidate border_candidate(const FitFrame& fit_frame,
                                 const ExpectedRim& expected,
                                 const RimStart& start) {
  FittedCandidate candidate;
  candidate.verdict = Verdict::Unfit;
  candidate.reason = "at the border: a part of its rim is outside of the picture";
  // A pixel either way says that this is no measurement.
  fill_geometry(fit_frame, expected, start.parameters, Eigen::Matrix2d::Identity(), candidate.fit);
  candidate.fit.score = start.support;
  candidate.fit.blur_px = start.parameters[kSigma];
  candidate.fit.background = start.parameters[kPlane];
  candidate.fit.contrast = start.parameters[kContrast];
  return candidate;
}

}  // namespace

FittedCandidate fit_candidate(const Image& image,
                              const FitFrame& fit_frame,
                              const ExpectedRim& expected,
                              const RimStart& start,
                              const LocateOptions& options) {
  if (start.at_border) return border_candidate(fit_frame, expected, start);
  const Eigen::Vector2d center = start.parameters.head<2>();
  const double radius = start.parameters[kRadius];
  FittedCandidate candidate;
  if (radius < kMinRadiusPx) {
    candidate.reason = "it is too small to be measured";
    return candidate;
  }
  RimProblem problem{make_window(image, fit_frame, center, radius, window_reach(radius)),
                     RimModel(expected.shape, center, radius),
                     image.full_scale()};
  const Estimate e = estimate(problem, start, options.min_score);

  const RimVector& p = e.solution.parameters;
  TargetFit& fit = candidate.fit;
  fill_geometry(fit_frame, expected, p, e.cov, fit);
  fit.score = e.correlation * rim_support(image, fit_frame, p);
  fit.blur_px = p[kSigma];
  fit.background = p[kPlane];
  fit.contrast = p[kContrast];
  fit.noise = e.rim_noise;
  fit.excluded = e.excluded;
  judge(image, fit_frame, expected, options, e, candidate);
  return candidate;
}

}  // namespace panelcal::internal
