// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/place.h"
#include "vision/template/fit.h"
#include "vision/template/model.h"
#include "vision/template/search.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Verdict = FittedCandidate::Verdict;

constexpr double kWholePicture = 0.985;  // of the template is seen if it is not at the border
constexpr double kMinVisible = 0.7;
constexpr double kMaxTemplateClipped = 0.5;
constexpr double kSamePlacePx = 2;
/// A turn or size outside of its tolerance by less than this many sigmas is inside.
constexpr double kTemplateSigmas = 3;

struct Expected {
  double turn = 0;
  double turn_tolerance = 0;
  double size_tolerance = 0;
  double gain_sign = 1;
};

Eigen::Vector2d template_middle(const TemplateModel& model) {
  return {0.5 * (model.width() - 1), 0.5 * (model.height() - 1)};
}

/// The template's rectangle in the picture; straight sides are bent by the lens.
std::vector<Eigen::Vector2d> template_outline(const FitFrame& fit_frame,
                                              const TemplateModel& model,
                                              const TemplateMap& map) {
  constexpr int kPerSide = 8;
  const double right = model.width() - 0.5;
  const double bottom = model.height() - 0.5;
  const std::array<Eigen::Vector2d, 4> corners = {
      Eigen::Vector2d(-0.5, -0.5), {right, -0.5}, {right, bottom}, {-0.5, bottom}};
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (int k = 0; k < kPerSide; ++k) {
      const Eigen::Vector2d t =
          corners[i] + (corners[(i + 1) % corners.size()] - corners[i]) * k / kPerSide;
      if (const auto u = fit_frame.to_image(map.to_frame(t))) outline.push_back(*u);
    }
  }
  return outline;
}

/// Place, size, angle and covariance in the units of the outside world.
void fill_template(const FitFrame& fit_frame,
                   const TemplateModel& model,
                   const TemplateFit& from,
                   TargetFit& fit) {
  const TemplateVector& p = from.parameters;
  const Eigen::Vector2d place = p.head<2>();
  const Eigen::Matrix2d cov = from.cov.topLeftCorner<2, 2>();
  set_place(fit_frame, place, cov, model.width() * model.pitch * std::exp(p[kLogScale]), fit);
  fit.angle = rad(p[kTurn]);
  fit.angle_sigma = rad(std::sqrt(std::max(0.0, from.cov(kTurn, kTurn))));
  fit.score = from.correlation * from.visible;
  fit.contrast = p[kGain];
  fit.background = p[kLevel] + p[kGain] * model.background;
  fit.noise = from.noise;
  fit.excluded = from.excluded;
  fit.visible = from.visible;
  fit.outlines_px.push_back(template_outline(fit_frame, model, TemplateMap(model, p)));
}

std::optional<std::string> template_size_problem(const FitFrame& fit_frame,
                                                 const TemplateModel& model,
                                                 const TemplateFit& fit,
                                                 double tolerance) {
  const double deviation = std::exp(fit.parameters[kLogScale]) - 1;
  const double sigma = std::sqrt(std::max(0.0, fit.cov(kLogScale, kLogScale)));
  if (std::abs(deviation) <= tolerance + kTemplateSigmas * sigma) return std::nullopt;
  const double asked = model.width() * model.pitch * fit_frame.unit();
  return fmt::format("its size is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     asked * (1 + deviation),
                     fit_frame.mapping() ? "mm" : "px",
                     100 * deviation,
                     asked,
                     100 * tolerance);
}

std::optional<std::string> turn_problem(const TemplateFit& fit, const Expected& expected) {
  const double deviation = fit.parameters[kTurn] - expected.turn;
  const double sigma = std::sqrt(std::max(0.0, fit.cov(kTurn, kTurn)));
  if (std::abs(deviation) <= expected.turn_tolerance + kTemplateSigmas * sigma) return std::nullopt;
  return fmt::format("it is turned by {:+.2f} degrees; {:.2f} are allowed",
                     rad(deviation).in_deg(),
                     rad(expected.turn_tolerance).in_deg());
}

void judge_template(const DetectorInput& input,
                    const FitFrame& fit_frame,
                    const TemplateModel& model,
                    const Expected& expected,
                    const TemplateFit& fit,
                    FittedCandidate& candidate) {
  const auto set = [&](Verdict verdict, std::string reason) {
    candidate.verdict = verdict;
    candidate.reason = std::move(reason);
  };
  const double contrast = expected.gain_sign * fit.parameters[kGain];
  const double min_contrast = input.options.min_contrast * input.image.full_scale();
  if (!fit.converged || !fit.cov.allFinite() || !candidate.fit.center.cov.allFinite()) {
    return set(Verdict::Unlikely, "it does not look like the target");
  }
  if (contrast < min_contrast) {
    return set(Verdict::Unlikely,
               fmt::format("its contrast is {:.1f} grey levels, at least {:.1f} are asked for",
                           contrast,
                           min_contrast));
  }
  if (candidate.fit.score < input.options.min_score) {
    return set(Verdict::Unlikely,
               fmt::format("its score is {:.2f}, at least {:.2f} is asked for",
                           candidate.fit.score,
                           input.options.min_score));
  }
  if (fit.visible < kMinVisible) {
    return set(Verdict::Unlikely,
               fmt::format("{:.0f} % of it look like the target, at least {:.0f} % are needed",
                           100 * fit.visible,
                           100 * kMinVisible));
  }
  if (fit.seen_share < kWholePicture) {
    return set(Verdict::Unfit, "at the border: a part of it is outside of the picture");
  }
  if (fit.clipped > kMaxTemplateClipped) {
    return set(
        Verdict::Unfit,
        fmt::format("saturated: {:.0f} % of its pixels are black or white", 100 * fit.clipped));
  }
  if (auto why = template_size_problem(fit_frame, model, fit, expected.size_tolerance)) {
    return set(Verdict::Unfit, *std::move(why));
  }
  if (auto why = turn_problem(fit, expected)) return set(Verdict::Unfit, *std::move(why));
  set(Verdict::Good, "");
}

/// Sigma of an even distribution over a tolerance.
double sigma_of_tolerance(double tolerance) {
  return tolerance / std::sqrt(3.0);
}

FittedCandidate fit_sighting(const DetectorInput& input,
                             const TemplateModel& model,
                             const Expected& expected,
                             const TemplateSighting& sighting) {
  const FitFrame fit_frame(input.mapping, sighting.at_px);
  TemplateVector start = TemplateVector::Zero();
  start[kTurn] = sighting.turn;
  start[kLogScale] = sighting.log_scale;
  const TemplatePrior prior{.turn = expected.turn,
                            .turn_sigma = sigma_of_tolerance(expected.turn_tolerance),
                            .log_scale_sigma = sigma_of_tolerance(expected.size_tolerance)};
  const TemplateFit fit = fit_template(
      input.image, fit_frame, model, start, search_level(model), prior, expected.gain_sign);
  FittedCandidate candidate;
  fill_template(fit_frame, model, fit, candidate.fit);
  judge_template(input, fit_frame, model, expected, fit, candidate);
  return candidate;
}

/// A candidate that only carries a reason; it stands where one would look.
FittedCandidate template_refusal(const DetectorInput& input, std::string reason) {
  FittedCandidate candidate;
  candidate.verdict = Verdict::Unfit;
  candidate.reason = std::move(reason);
  const PixelBox box = input.area.box(input.image, 0);
  const Eigen::Vector2d middle(box.x0 + 0.5 * (box.width - 1), box.y0 + 0.5 * (box.height - 1));
  // The whole box either way says that this is no measurement.
  const double side = std::max({1, box.width, box.height});
  candidate.fit.center = {position_px<frame::Image>(middle),
                          side * side * Eigen::Matrix2d::Identity()};
  return candidate;
}

/// Candidates that ended at one place are one: the best of them.
void keep_distinct(std::vector<FittedCandidate>& candidates) {
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const FittedCandidate& a, const FittedCandidate& b) {
        if (a.verdict != b.verdict) return a.verdict < b.verdict;
        return a.fit.score > b.fit.score;
      });
  std::vector<FittedCandidate> kept;
  for (FittedCandidate& candidate : candidates) {
    const bool is_new = std::ranges::none_of(kept, [&](const FittedCandidate& other) {
      const Eigen::Vector2d apart =
          candidate.fit.center.position.in_px() - other.fit.center.position.in_px();
      return apart.norm() < kSamePlacePx;
    });
    if (is_new) kept.push_back(std::move(candidate));
  }
  candidates = std::move(kept);
}

}  // namespace

std::vector<FittedCandidate> detect_templates(const DetectorInput& input) {
  const Target& target = input.target;
  const double width = frame_length(target.size, target.size_px, input.mapping).value_or(0);
  const Image& picture = target.picture->image;
  const double height = width * picture.height() / std::max(1, picture.width());
  if (width > input.image.width() + input.image.height() ||
      height > input.image.width() + input.image.height()) {
    return {template_refusal(input, "the template is larger than the picture")};
  }
  const auto model = make_template_model(*target.picture, width, input.mapping ? -1 : 1);
  if (!model) return {template_refusal(input, model.error())};

  const Expected expected{.turn = target.angle.in_rad(),
                          .turn_tolerance = target.angle_tolerance.in_rad(),
                          .size_tolerance = target.size_tolerance,
                          .gain_sign = target.polarity == Polarity::Bright ? 1.0 : -1.0};
  const TemplateRange range{.turn = expected.turn,
                            .turn_tolerance = expected.turn_tolerance,
                            .log_scale_tolerance = std::log1p(expected.size_tolerance),
                            .gain_sign = expected.gain_sign};
  const double reach = model->pitch * (model->reference - template_middle(*model)).norm() +
                       0.5 * std::hypot(width, height) * (1 + expected.size_tolerance);
  const double cell = 1 << search_level(*model);
  std::vector<FittedCandidate> candidates;
  for (const TemplateSighting& sighting : search_template(input.image,
                                                          input.area.box(input.image, reach + cell),
                                                          *model,
                                                          input.mapping,
                                                          range,
                                                          static_cast<int>(kMaxFittedSlow))) {
    if (!input.area.contains(sighting.at_px, 2 * cell)) continue;
    FittedCandidate candidate = fit_sighting(input, *model, expected, sighting);
    if (input.area.contains(candidate.fit.center.position.in_px(), 0)) {
      candidates.push_back(std::move(candidate));
    }
  }
  keep_distinct(candidates);
  return candidates;
}

}  // namespace panelcal::internal
