// SPDX-License-Identifier: Apache-2.0
#include "machine/look/inspections.h"

#include <algorithm>
#include <string>
#include <utility>

#include "machine/look/view_mean.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Rounding of an axis that did not move; far below what a pixel can show.
constexpr double kSameAxis_mm = 1e-6;

std::string scatter_text(const Displacement<frame::Actual>& scatter) {
  return fmt::format("{:.4f}, {:.4f} mm", scatter.in_mm().x(), scatter.in_mm().y());
}

/// The mean of the places, with the covariance of one of them.
PositionEstimate<frame::Actual> mean_place(
    const std::vector<PositionEstimate<frame::Actual>>& places) {
  const auto n = static_cast<double>(places.size());
  PositionEstimate<frame::Actual> mean = places.front();
  mean.cov.setZero();
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  for (const auto& place : places) {
    sum_mm += (place.position - places.front().position).in_mm();
    mean.cov += place.cov / n;
  }
  const Eigen::Vector2d offset_mm = sum_mm / n;
  mean.position = mean.position + displacement_mm<frame::Actual>(offset_mm);
  return mean;
}

}  // namespace

void Inspections::add(TakenPicture picture, Sight sight) {
  const std::size_t n = places_.size();
  places_.push_back(sight.place);
  if (n == 0) {
    sum_ = std::move(picture);
    first_ = std::move(sight);
    return;
  }
  first_.score = std::min(*first_.score, *sight.score);
  const bool is_same = sum_ && (picture.axis - sum_->axis).in_mm().norm() <= kSameAxis_mm &&
                       picture.image.pixels().size() == sum_->image.pixels().size() &&
                       picture.image.full_scale() == sum_->image.full_scale();
  if (!is_same) return sum_.reset();
  const std::span<float> sum = sum_->image.pixels();
  std::ranges::transform(sum, picture.image.pixels(), sum.begin(), std::plus());
}

Expected<Sight> Inspections::result(const PictureLocator& locator,
                                    const MeasurementRequest& request,
                                    const Look& look) const {
  Sight whole = first_;
  whole.scatter = scatter_of(places_);
  whole.place = mean_place(places_);
  whole.candidates.clear();
  whole.listed.reset();
  if (sum_) {
    TakenPicture mean = *sum_;
    const auto n = static_cast<float>(places_.size());
    for (float& pixel : mean.image.pixels()) pixel /= n;
    PANELCAL_TRY(const Sight in_mean, locator.look(request, look, mean, false));
    if (!in_mean.is_found()) {
      whole.status = MeasurementStatus::Rejected;
      whole.reason = fmt::format("{} inspections scatter by {}, and their mean shows no target: {}",
                                 places_.size(),
                                 scatter_text(*whole.scatter),
                                 in_mean.reason);
      return whole;
    }
    whole.place = in_mean.place;
    whole.by_camera = in_mean.by_camera;
    whole.blind = in_mean.blind;
    whole.candidates = in_mean.candidates;
    whole.listed = in_mean.listed;
  }
  whole.place.cov += excess_scatter(places_, whole.blind ? 1 : 2);
  return whole;
}

}  // namespace panelcal::internal
