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
    outline.push_back(center + r * Eigen::Vector2d(std::cos(phi), std::sin(phi)));
  }
  return in_picture(fit_frame, outline);
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

Problem rim_size_problem(const FitFrame& fit_frame,
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
Problem unseen_problem(const RimEstimate& e, const LocateOptions& options) {
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

Problem focus_problem(const RimFit& fit, const LocateOptions& options) {
  const double most = max_edge_sigma(fit.estimate.parameters[kRadius]);
  if (!(fit.target.blur_px > std::min(options.max_blur_px, 0.99 * most))) return std::nullopt;
  return fmt::format(
      "out of focus: its edge is blurred by {:.1f} px, at most {:.1f} are accepted (max_blur_px)",
      fit.target.blur_px,
      std::min(options.max_blur_px, most));
}

bool has_hole(const ExpectedRim& expected, const RimVector& p, double min_contrast) {
  const double contrast = (p[kContrast] - p[kHole]) * expected.sign();
  const double reach = std::hypot(p[kHoleX], p[kHoleY]) + p[kInnerRadius];
  return !(contrast < min_contrast || reach > p[kRadius]);
}

Problem shape_problem(const ExpectedRim& expected,
                      const LocateOptions& options,
                      const RimFit& fit) {
  const RimEstimate& e = fit.estimate;
  const double max_oval = expected.allowed_oval(options.max_oval);
  const double oval = 1 - fit.target.axis_ratio;
  if (oval - kOvalSigmas * 2 * e.oval_sigma > max_oval) {
    return fmt::format(
        "its shape: the diameters differ by {:.1f} %, {:.1f} % are allowed (max_oval)",
        100 * oval,
        100 * max_oval);
  }
  if (e.roughness > options.max_roughness) {
    return fmt::format(
        "its shape: the rim is {:.1f} % of the radius from round, {:.1f} % are "
        "allowed (max_roughness)",
        100 * e.roughness,
        100 * options.max_roughness);
  }
  if (e.lobes > options.max_lobes) {
    return fmt::format(
        "its shape: the rim has {} lobes of {:.1f} % of the radius, {:.1f} % are "
        "allowed (max_lobes)",
        e.n_lobes,
        100 * e.lobes,
        100 * options.max_lobes);
  }
  return std::nullopt;
}

}  // namespace

bool RimFit::is_too_small() const {
  return start.parameters[kRadius] < kMinRadiusPx;
}

RimFit fit_candidate(const DetectorInput& input,
                     const FitFrame& fit_frame,
                     const ExpectedRim& expected,
                     const RimStart& start) {
  RimFit fit{fit_frame, start, {}, {}};
  TargetFit& target = fit.target;
  if (start.at_border || fit.is_too_small()) {
    const RimVector& p = start.parameters;
    fill_geometry(fit_frame, expected, p, Eigen::Matrix2d::Identity(), target);
    if (!start.at_border) return fit;
    target.score = start.support;
    target.visible = start.inside;
    target.blur_px = p[kSigma];
    target.background = p[kLevel];
    target.contrast = p[kContrast];
    return fit;
  }
  fit.estimate = estimate_rim(input.image, fit_frame, expected, start, input.options);
  const RimEstimate& e = fit.estimate;
  const RimVector& p = e.parameters;
  fill_geometry(fit_frame, expected, p, e.center_cov, target);
  target.score = e.correlation * e.arc;
  target.visible = e.visible;
  target.blur_px = p[kSigma];
  target.background = p[kLevel];
  target.contrast = p[kContrast];
  target.noise = e.rim_noise;
  target.excluded = e.excluded;
  return fit;
}

Judgement judge_rim(const DetectorInput& input, const ExpectedRim& expected, const RimFit& fit) {
  const LocateOptions& options = input.options;
  const RimEstimate& e = fit.estimate;
  const RimVector& p = e.parameters;
  if (fit.start.at_border) {
    return unfit(fmt::format(
        "at the border: a part of its rim is outside of the picture, {:.0f} % are inside",
        100 * fit.start.inside));
  }
  if (fit.is_too_small()) return unlikely("it is too small to be measured");
  const double support = fit.start.support;
  if (!e.converged && support >= kLeastArc && support < options.min_visible) {
    return unfit(arc_reason(support, options));
  }
  if (!e.converged || !fit.target.center.cov.allFinite()) return unlikely(kUnlikeTarget);
  if (auto problem = contrast_problem(input.sign() * p[kContrast], input.min_contrast())) {
    return unlikely(*std::move(problem));
  }
  if (e.clipped > options.max_clipped) {
    return unfit(
        fmt::format("saturated: {:.0f} % of its rim's pixels are clipped, at most {:.0f} % "
                    "leave an edge to measure (max_clipped)",
                    100 * e.clipped,
                    100 * options.max_clipped));
  }
  if (auto problem = unseen_problem(e, options)) return unfit(*std::move(problem));
  if (auto problem = score_problem(fit.target.score, input.options.min_score))
    return unlikely(*std::move(problem));
  if (auto problem = focus_problem(fit, options)) return unfit(*std::move(problem));
  if (expected.shape == Shape::Ring && !has_hole(expected, p, input.min_contrast())) {
    return unlikely("it has no hole that is darker or brighter as a ring's is");
  }
  if (auto problem = rim_size_problem(fit.fit_frame, expected, p))
    return unfit(*std::move(problem));
  if (auto problem = shape_problem(expected, options, fit)) return unfit(*std::move(problem));
  return {};
}

}  // namespace panelcal::internal
