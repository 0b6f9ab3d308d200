// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/pipeline.h"
#include "vision/fit/place.h"
#include "vision/template/fit.h"
#include "vision/template/model.h"
#include "vision/template/search.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr double kWholePicture = 0.985;  // of the template is seen if it is not at the border
constexpr double kMinVisible = 0.7;
constexpr double kMaxTemplateClipped = 0.5;
constexpr double kSamePlacePx = 2;
/// A size outside of its tolerance by less than this many sigmas is inside.
constexpr double kTemplateSigmas = 3;

/// The template's rectangle in the picture; straight sides are bent by the lens.
std::vector<Eigen::Vector2d> template_outline(const FitFrame& fit_frame,
                                              const TemplateModel& model,
                                              const TemplateMap& map) {
  constexpr int kPerSide = 8;
  const auto corners = model.corners();
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
    for (int k = 0; k < kPerSide; ++k) {
      outline.push_back(map.to_frame(corners[i] + side * k / kPerSide));
    }
  }
  return in_picture(fit_frame, outline);
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

/// Sigma of an even distribution over a tolerance.
double sigma_of_tolerance(double tolerance) {
  return tolerance / std::sqrt(3.0);
}

/// What a given picture shows.
class Templates {
 public:
  using Sighting = TemplateSighting;
  struct Fit {
    FitFrame fit_frame;
    TemplateFit pose;
    TargetFit target;
  };

  explicit Templates(const DetectorInput& input)
      : input_(input),
        width_(frame_length(input.target.size, input.target.size_px, input.mapping).value_or(0)),
        prior_{.turn = input.target.angle.in_rad(),
               .turn_sigma = sigma_of_tolerance(input.target.angle_tolerance.in_rad()),
               .log_scale_sigma = sigma_of_tolerance(input.target.size_tolerance)} {
    const Image& picture = input.target.picture->image;
    height_ = width_ * picture.height() / std::max(1, picture.width());
    const int largest = input.image.width() + input.image.height();
    if (width_ > largest || height_ > largest) {
      model_ = tl::make_unexpected(std::string("the template is larger than the picture"));
    } else {
      model_ = make_template_model(*input.target.picture, width_, input.mapping ? -1 : 1);
    }
  }

  Proposals<Sighting> propose() const {
    if (!model_) return {{}, unfit(model_.error())};
    const Target& target = input_.target;
    const TemplateRange range{.turn = target.angle.in_rad(),
                              .turn_tolerance = target.angle_tolerance.in_rad(),
                              .log_scale_tolerance = std::log1p(target.size_tolerance),
                              .gain_sign = input_.sign()};
    const double reach = model_->pitch * (model_->reference - model_->middle()).norm() +
                         0.5 * std::hypot(width_, height_) * (1 + target.size_tolerance);
    const double cell = 1 << search_level(*model_);
    auto sightings = search_template(input_.image,
                                     input_.area.box(input_.image, reach + cell),
                                     *model_,
                                     input_.mapping,
                                     range,
                                     static_cast<int>(kMaxFittedSlow));
    std::erase_if(sightings, [&](const Sighting& sighting) {
      return !input_.area.contains(sighting.at_px, 2 * cell);
    });
    return {std::move(sightings)};
  }

  Fit fit(const Sighting& sighting) const {
    Fit fit{FitFrame(input_.mapping, sighting.at_px), {}, {}};
    TemplateVector start = TemplateVector::Zero();
    start[kTurn] = sighting.turn;
    start[kLogScale] = sighting.log_scale;
    fit.pose = fit_template(
        input_.image, fit.fit_frame, *model_, start, search_level(*model_), prior_, input_.sign());
    fill_template(fit.fit_frame, *model_, fit.pose, fit.target);
    return fit;
  }

  Judgement judge(const Fit& fit) const {
    const TemplateFit& pose = fit.pose;
    const TargetFit& target = fit.target;
    if (!pose.converged || !pose.cov.allFinite() || !target.center.cov.allFinite()) {
      return unlikely(kUnlikeTarget);
    }
    if (auto problem = contrast_problem(input_.sign() * target.contrast, input_.min_contrast())) {
      return unlikely(*std::move(problem));
    }
    if (auto problem = score_problem(target.score, input_.options.min_score))
      return unlikely(*std::move(problem));
    if (pose.visible < kMinVisible) {
      return unlikely(
          fmt::format("{:.0f} % of it look like the target, at least {:.0f} % are needed",
                      100 * pose.visible,
                      100 * kMinVisible));
    }
    if (pose.seen_share < kWholePicture) {
      return unfit("at the border: a part of it is outside of the picture");
    }
    if (pose.clipped > kMaxTemplateClipped) {
      return unfit(
          fmt::format("saturated: {:.0f} % of its pixels are black or white", 100 * pose.clipped));
    }
    if (auto problem = template_size_problem(fit)) return unfit(*std::move(problem));
    const double turn_rad = pose.parameters[kTurn] - prior_.turn;
    const double tolerance_rad = input_.target.angle_tolerance.in_rad();
    if (auto problem = turn_problem(turn_rad, target.angle_sigma.in_rad(), tolerance_rad)) {
      return unfit(*std::move(problem));
    }
    return {};
  }

 private:
  Problem template_size_problem(const Fit& fit) const {
    const double asked = model_->width() * model_->pitch;
    const double sigma = std::sqrt(std::max(0.0, fit.pose.cov(kLogScale, kLogScale)));
    return size_problem(fit.fit_frame,
                        "its size",
                        asked * std::exp(fit.pose.parameters[kLogScale]),
                        asked,
                        input_.target.size_tolerance,
                        kTemplateSigmas * sigma);
  }

  const DetectorInput& input_;
  double width_;  ///< frame units
  double height_ = 0;
  TemplatePrior prior_;
  tl::expected<TemplateModel, std::string> model_;  ///< or why there is none
};

}  // namespace

std::vector<FittedCandidate> detect_templates(const DetectorInput& input) {
  return detect(input, Templates(input), kSamePlacePx);
}

}  // namespace panelcal::internal
