// SPDX-License-Identifier: Apache-2.0
#include "vision/round/candidate_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/place.h"
#include "vision/round/estimate.h"
#include "vision/round/fit.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

constexpr double kMinRadiusPx = 3;
/// With less of the rim there is no telling an arc from chance.
constexpr double kLeastArc = 0.3;
/// With less of the rim another circle or a diamond may have as much, however it is spread.
constexpr double kMajorityOfRim = 0.6;
/// Noise alone makes ovals of fewer sigmas.
constexpr double kOvalSigmas = 3.5;
constexpr int kOutlineNodes = 72;

/// Places on an oval around `center`, as far as the picture's frame goes.
std::vector<Eigen::Vector2d> circle_outline(const FitFrame& fit_frame,
                                            const Eigen::Vector2d& center,
                                            double radius,
                                            const RimVector& p) {
  std::vector<Eigen::Vector2d> outline;
  outline.reserve(kOutlineNodes);
  for (int i = 0; i < kOutlineNodes; ++i) {
    const double phi = 2 * std::numbers::pi * i / kOutlineNodes;
    const double r =
        radius * (1 + p[kOval] * std::cos(2 * phi) + p[kOvalDiagonal] * std::sin(2 * phi));
    const auto u = fit_frame.to_image(center + r * Eigen::Vector2d(std::cos(phi), std::sin(phi)));
    if (u) outline.push_back(*u);
  }
  return outline;
}

/// Center, sizes and covariance in the units of the outside world.
void fill_geometry(const FitFrame& fit_frame,
                   const ExpectedRim& expected,
                   const RimVector& p,
                   const Eigen::Matrix2d& cov,
                   TargetFit& fit) {
  const Eigen::Vector2d center = p.head<2>();
  set_place(fit_frame, center, cov, 2 * p[kRadius], fit);
  fit.outlines_px.push_back(circle_outline(fit_frame, center, p[kRadius], p));
  const double oval = std::hypot(p[kOval], p[kOvalDiagonal]);
  fit.axis_ratio = (1 - oval) / (1 + oval);
  if (expected.shape == Shape::Ring) {
    const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(fit.center.position.in_px()).inverse();
    fit.inner_size = px(2 * p[kInnerRadius] * std::sqrt(std::abs(px_from_frame.determinant())));
    const Eigen::Vector2d hole(p[kHoleX], p[kHoleY]);
    fit.hole_offset_px = px_from_frame * hole;
    fit.outlines_px.push_back(circle_outline(fit_frame, center + hole, p[kInnerRadius], p));
  }
}

std::optional<std::string> unfit_circle_reason(const FitFrame& fit_frame,
                                               const ExpectedRim& expected,
                                               const RimVector& p) {
  if (auto reason = size_problem(
          fit_frame, "its size", 2 * p[kRadius], 2 * expected.radius, expected.size_tolerance)) {
    return reason;
  }
  if (!expected.inner_radius) return std::nullopt;
  // Relative to the outer size: a thin pin hole's own diameter would be an unfair measure.
  const double tolerance = expected.size_tolerance * expected.radius / *expected.inner_radius;
  return size_problem(
      fit_frame, "its inner size", 2 * p[kInnerRadius], 2 * *expected.inner_radius, tolerance);
}

std::string arc_reason(double arc, const LocateOptions& options) {
  return fmt::format(
      "only an arc is visible: {:.0f} % of its rim, at least {:.0f} % are asked for "
      "(min_visible)",
      100 * arc,
      100 * options.min_visible);
}

/// Parts that are spread around tell more of the center than an arc of their length.
std::optional<std::string> unseen_reason(const RimEstimate& e, const LocateOptions& options) {
  if (e.visible < kLeastArc) return std::nullopt;
  if (e.arc < options.min_visible) return arc_reason(e.arc, options);
  const double least = std::min(kMajorityOfRim, options.min_visible);
  if (e.visible >= least) return std::nullopt;
  return fmt::format(
      "only parts are visible: {:.0f} % of its rim, at least {:.0f} % are needed "
      "however they are spread (min_visible)",
      100 * e.visible,
      100 * least);
}

void judge_circle(const Image& image,
                  const FitFrame& fit_frame,
                  const ExpectedRim& expected,
                  const LocateOptions& options,
                  const RimEstimate& e,
                  double support,
                  FittedCandidate& candidate) {
  const RimVector& p = e.parameters;
  const double contrast = p[kContrast] * expected.sign();
  const double min_contrast = options.min_contrast * image.full_scale();
  const auto set = [&](Verdict verdict, std::string reason) {
    candidate.verdict = verdict;
    candidate.reason = std::move(reason);
  };
  if (!e.converged && support >= kLeastArc && support < options.min_visible) {
    return set(Verdict::Unfit, arc_reason(support, options));
  }
  if (!e.converged || !candidate.fit.center.cov.allFinite()) {
    return set(Verdict::Unlikely, "it does not look like the target");
  }
  if (contrast < min_contrast) {
    return set(Verdict::Unlikely,
               fmt::format("its contrast is {:.1f} grey levels, at least {:.1f} are asked for "
                           "(min_contrast)",
                           contrast,
                           min_contrast));
  }
  if (e.clipped > options.max_clipped) {
    return set(Verdict::Unfit,
               fmt::format("saturated: {:.0f} % of its rim's pixels are clipped, at most {:.0f} % "
                           "leave an edge to measure (max_clipped)",
                           100 * e.clipped,
                           100 * options.max_clipped));
  }
  if (auto reason = unseen_reason(e, options)) return set(Verdict::Unfit, *std::move(reason));
  if (candidate.fit.score < options.min_score) {
    return set(Verdict::Unlikely,
               fmt::format("its score is {:.2f}, at least {:.2f} is asked for (min_score)",
                           candidate.fit.score,
                           options.min_score));
  }
  if (candidate.fit.blur_px > std::min(options.max_blur_px, 0.99 * max_edge_sigma(p[kRadius]))) {
    return set(Verdict::Unfit,
               fmt::format("out of focus: its edge is blurred by {:.1f} px, at most {:.1f} are "
                           "accepted (max_blur_px)",
                           candidate.fit.blur_px,
                           std::min(options.max_blur_px, max_edge_sigma(p[kRadius]))));
  }
  if (expected.shape == Shape::Ring) {
    const double hole_contrast = (p[kContrast] - p[kHole]) * expected.sign();
    const double reach = std::hypot(p[kHoleX], p[kHoleY]) + p[kInnerRadius];
    if (hole_contrast < min_contrast || reach > p[kRadius]) {
      return set(Verdict::Unlikely, "it has no hole that is darker or brighter as a ring's is");
    }
  }
  if (auto reason = unfit_circle_reason(fit_frame, expected, p)) {
    return set(Verdict::Unfit, *std::move(reason));
  }
  const double max_oval = expected.allowed_oval(options.max_oval);
  if (1 - candidate.fit.axis_ratio - kOvalSigmas * 2 * e.oval_sigma > max_oval) {
    return set(Verdict::Unfit,
               fmt::format("its shape: the diameters differ by {:.1f} %, {:.1f} % are allowed "
                           "(max_oval)",
                           100 * (1 - candidate.fit.axis_ratio),
                           100 * max_oval));
  }
  if (e.roughness > options.max_roughness) {
    return set(Verdict::Unfit,
               fmt::format("its shape: the rim is {:.1f} % of the radius from round, {:.1f} % are "
                           "allowed (max_roughness)",
                           100 * e.roughness,
                           100 * options.max_roughness));
  }
  if (e.lobes > options.max_lobes) {
    return set(
        Verdict::Unfit,
        fmt::format("its shape: the rim has {} lobes of {:.1f} % of the radius, {:.1f} % are "
                    "allowed (max_lobes)",
                    e.n_lobes,
                    100 * e.lobes,
                    100 * options.max_lobes));
  }
  set(Verdict::Good, "");
}

/// A rim that leaves the picture is not fitted: what is missing would be guessed.
FittedCandidate border_candidate(const FitFrame& fit_frame,
                                 const ExpectedRim& expected,
                                 const RimStart& start) {
  FittedCandidate candidate;
  candidate.verdict = Verdict::Unfit;
  candidate.reason =
      fmt::format("at the border: a part of its rim is outside of the picture, {:.0f} % are inside",
                  100 * start.inside);
  // A pixel either way says that this is no measurement.
  fill_geometry(fit_frame, expected, start.parameters, Eigen::Matrix2d::Identity(), candidate.fit);
  candidate.fit.score = start.support;
  candidate.fit.visible = start.inside;
  candidate.fit.blur_px = start.parameters[kSigma];
  candidate.fit.background = start.parameters[kLevel];
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
  FittedCandidate candidate;
  if (start.parameters[kRadius] < kMinRadiusPx) {
    candidate.reason = "it is too small to be measured";
    fill_geometry(
        fit_frame, expected, start.parameters, Eigen::Matrix2d::Identity(), candidate.fit);
    return candidate;
  }
  const RimEstimate e = estimate_rim(image, fit_frame, expected, start, options);
  const RimVector& p = e.parameters;
  TargetFit& fit = candidate.fit;
  fill_geometry(fit_frame, expected, p, e.center_cov, fit);
  fit.score = e.correlation * e.arc;
  fit.visible = e.visible;
  fit.blur_px = p[kSigma];
  fit.background = p[kLevel];
  fit.contrast = p[kContrast];
  fit.noise = e.rim_noise;
  fit.excluded = e.excluded;
  judge_circle(image, fit_frame, expected, options, e, start.support, candidate);
  return candidate;
}

}  // namespace panelcal::internal
