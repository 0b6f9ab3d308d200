// SPDX-License-Identifier: Apache-2.0
#include "machine/look/vision_procedure.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "machine/look/focus.h"
#include "machine/look/inspections.h"
#include "machine/look/search_spiral.h"
#include "machine/look/view_mean.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Beyond the target itself, what neighbouring views of a search overlap by, so that its rim and
/// some of its surroundings are in one picture.
constexpr double kSearchMargin_px = 12;
/// A slot is taken for one along an axis of the panel while it is turned by less than this.
constexpr double kSlotCosine = 0.7071;
constexpr double kGateSigmas = 3;

Measurement answer(const MeasurementRequest& request, const Sight& sight) {
  Measurement measurement;
  measurement.request = request;
  measurement.status = sight.status;
  measurement.measured = sight.place;
  measurement.score = sight.score;
  measurement.scatter = sight.scatter;
  if (sight.is_found()) measurement.by_camera = sight.by_camera;
  measurement.image = sight.image;
  measurement.reason = sight.reason;
  measurement.candidates = sight.candidates;
  measurement.listed = sight.listed;
  return measurement;
}

/// The coordinate that counts where a slot's middle line meets the expected other one.
void take_one_coordinate(const MeasurementRequest& request, Sight& sight) {
  if (!sight.is_found() || !sight.blind) return;
  const bool is_x = request.axes == ObservedAxes::X;
  const Eigen::Vector2d across(-sight.blind->y(), sight.blind->x());
  const int i = is_x ? 0 : 1;
  if (std::abs(across(i)) < kSlotCosine) {
    sight.status = MeasurementStatus::Rejected;
    sight.reason = fmt::format("slot along {0}: {0} not measurable", is_x ? "x" : "y");
    return;
  }
  const Eigen::Vector2d& expected_mm = request.expected.in_mm();
  const double across_mm = across.dot(sight.place.position.in_mm() - expected_mm);
  Eigen::Vector2d place_mm = expected_mm;
  place_mm(i) += across_mm / across(i);
  const double variance_mm2 = across.dot(sight.place.cov * across) / (across(i) * across(i));
  const double along_mm2 = sight.blind->dot(sight.place.cov * *sight.blind);
  sight.place.position = position_mm<frame::Actual>(place_mm);
  const Eigen::Matrix<double, 1, 5> across_by_camera = across.transpose() * sight.by_camera;
  sight.by_camera.setZero();
  sight.by_camera.row(i) = across_by_camera / across(i);
  sight.place.cov = Eigen::Matrix2d::Zero();
  sight.place.cov(i, i) = variance_mm2;
  sight.place.cov(1 - i, 1 - i) = along_mm2;
}

std::string numbers_of(const internal::ViewMean& mean) {
  std::string out;
  for (const double residual_mm : mean.residual_mm) {
    out += fmt::format("{}{:.4f}", out.empty() ? "" : ", ", residual_mm);
  }
  return out;
}

}  // namespace

Expected<VisionProcedure> VisionProcedure::create(const MachineConfig& config,
                                                  PictureObserver observer) {
  PANELCAL_TRY(PictureLocator locator, PictureLocator::create(config, std::move(observer)));
  return VisionProcedure(config, std::move(locator));
}

VisionProcedure::VisionProcedure(const MachineConfig& config, PictureLocator locator)
    : locator_(std::move(locator)), options_(config.vision) {
}

std::optional<std::size_t> VisionProcedure::n_pictures(const MeasurementRequest& request) const {
  if (search_area(request)) return std::nullopt;
  const auto n_inspections = static_cast<std::size_t>(std::max(1, request.settings.inspections));
  return mark_offsets(request).size() * n_inspections;
}

std::vector<Displacement<frame::Machine>> VisionProcedure::mark_offsets(
    const MeasurementRequest& request) const {
  if (!request.settings.delta) return {Displacement<frame::Machine>()};
  const double d_mm = request.settings.delta->in_mm();
  const auto at = [&](double x, double y) {
    return displacement_mm<frame::Machine>(x * d_mm, y * d_mm);
  };
  if (options_.four_views == FourViews::Corners)
    return {at(1, 1), at(-1, 1), at(-1, -1), at(1, -1)};
  return {at(1, 0), at(0, 1), at(-1, 0), at(0, -1)};
}

std::optional<Length> VisionProcedure::search_area(const MeasurementRequest& request) const {
  if (!request.settings.search.value_or(false)) return std::nullopt;
  if (request.settings.search_area) return request.settings.search_area;
  return options_.search_area;
}

Expected<Look> VisionProcedure::first_look(const MeasurementRequest& request,
                                           const Position<frame::Machine>& expected,
                                           int i_mark) const {
  const bool has_tools = request.settings.tools.size() > 1;
  Look look;
  look.view.axis = expected;
  look.view.i_view = i_mark;
  look.view.i_tool = has_tools ? i_mark : 0;
  look.view.focus_z = focus_z_;
  PANELCAL_TRY(look.target, locator_.target_of(request, look.view.i_tool));
  look.expected = expected;
  look.shown = expected;
  look.radius = options_.search_radius;
  return look;
}

Expected<std::vector<Look>> VisionProcedure::first_looks(const MeasurementRequest& request) const {
  PANELCAL_CHECK(locator_.check(request));
  const auto offsets = mark_offsets(request);
  const std::optional<Length> area = search_area(request);
  const int n_inspections = area ? 1 : std::max(1, request.settings.inspections);
  std::vector<Look> looks;
  for (std::size_t k = 0; k < (area ? 1 : offsets.size()); ++k) {
    const Position<frame::Machine> expected = request.expected_in_machine() + offsets[k];
    PANELCAL_TRY(Look look, first_look(request, expected, static_cast<int>(k)));
    if (area) look.radius = area;
    for (int i = 0; i < n_inspections; ++i) {
      look.view.i_inspection = i;
      looks.push_back(look);
    }
  }
  return looks;
}

Expected<Sight> VisionProcedure::inspect(const MeasurementRequest& request,
                                         Look look,
                                         ViewTaker& taker) const {
  const int n = std::max(1, request.settings.inspections);
  internal::Inspections inspections;
  for (int i = 0; i < n; ++i) {
    look.view.i_inspection = i;
    PANELCAL_TRY(TakenPicture picture, taker.take(request, look.view));
    PANELCAL_TRY(Sight one, locator_.look(request, look, picture));
    if (!one.is_found()) {
      if (n > 1) one.reason = fmt::format("{} of {} pictures: {}", i + 1, n, one.reason);
      return one;
    }
    // A single measurement stays what it is, to the bit.
    if (n == 1) return one;
    inspections.add(std::move(picture), std::move(one));
  }
  return inspections.result(locator_, request, look);
}

Expected<Sight> VisionProcedure::search(const MeasurementRequest& request,
                                        Length area,
                                        Look& look,
                                        ViewTaker& taker) const {
  PANELCAL_TRY(const ZoomedCamera camera, locator_.camera_of(request));
  const Length margin = outer_radius(look.target, camera.mapping) +
                        mm(kSearchMargin_px * camera.mapping.parameters().scale_mm_per_px);
  PANELCAL_TRY(const UsableView usable, usable_view(camera, margin));
  PANELCAL_TRY(const auto places, search_spiral(look.expected, area, usable));
  look.radius = area;
  Sight likeliest;
  std::size_t n_seen = 0;
  for (const Position<frame::Machine>& place : places) {
    look.view.axis = place;
    look.view.i_view = static_cast<int>(n_seen);
    look.shown = place;
    look.words = n_seen == 0 ? "" : fmt::format(", view {} of {}", n_seen + 1, places.size());
    Expected<Sight> sight = inspect(request, look, taker);
    // A folder shows as much of a search as was recorded.
    const bool is_end = !sight && n_seen > 0 && sight.error().code == Code::PictureMissing;
    if (is_end) break;
    if (!sight) return sight;
    ++n_seen;
    if (sight->status == MeasurementStatus::Found) return sight;
    sight->reason = fmt::format("view {} of {}: {}", n_seen, places.size(), sight->reason);
    if (sight->status == MeasurementStatus::Ambiguous) return sight;
    const bool says_more = sight->status == MeasurementStatus::Rejected &&
                           likeliest.status != MeasurementStatus::Rejected;
    if (n_seen == 1 || says_more) likeliest = *std::move(sight);
  }
  likeliest.reason = fmt::format("not in {} of {} views within {:.3f} mm; {}",
                                 n_seen,
                                 places.size(),
                                 area.in_mm(),
                                 likeliest.reason);
  return likeliest;
}

Expected<Sight> VisionProcedure::find(const MeasurementRequest& request,
                                      Look& look,
                                      ViewTaker& taker) const {
  const std::optional<Length> area = search_area(request);
  return area ? search(request, *area, look, taker) : inspect(request, look, taker);
}

Expected<Measurement> VisionProcedure::measure_one(const MeasurementRequest& request,
                                                   ViewTaker& taker) const {
  PANELCAL_TRY(Look look, first_look(request, request.expected_in_machine(), 0));
  PANELCAL_TRY(Sight sight, find(request, look, taker));
  take_one_coordinate(request, sight);
  return answer(request, sight);
}

Expected<Measurement> VisionProcedure::measure_four(const MeasurementRequest& request,
                                                    ViewTaker& taker) const {
  const auto offsets = mark_offsets(request);
  std::vector<internal::ViewDeviation> views;
  Displacement<frame::Machine> shift;  // what the search of the first mark found
  int i_view = 0;
  Sight whole;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    const Position<frame::Machine> expected = request.expected_in_machine() + offsets[k];
    PANELCAL_TRY(Look look, first_look(request, expected + shift, static_cast<int>(k)));
    look.view.i_view = i_view;
    look.words = fmt::format(", mark {} of {}", k + 1, offsets.size());
    PANELCAL_TRY(Sight sight, k == 0 ? find(request, look, taker) : inspect(request, look, taker));
    i_view = look.view.i_view + 1;
    if (!sight.is_found()) {
      // Of one mark, which is not the target's place.
      sight.candidates.clear();
      sight.listed.reset();
      sight.reason = fmt::format("mark {} of {} (vision tool {}): {}",
                                 k + 1,
                                 offsets.size(),
                                 look.target.number,
                                 sight.reason);
      return answer(request, sight);
    }
    const Displacement<frame::Machine> from_work_zero = expected - request.work_zero;
    const Eigen::Vector2d deviation_mm = sight.place.position.in_mm() - from_work_zero.in_mm();
    if (k == 0 && search_area(request)) shift = displacement_mm<frame::Machine>(deviation_mm);
    views.push_back(
        {offsets[k].in_mm(), deviation_mm, sight.place.cov, sight.blind, sight.by_camera});
    whole.image = k == 0 ? sight.image : whole.image;
    whole.score = std::min(*sight.score, whole.score.value_or(*sight.score));
  }
  const auto mean = internal::mean_of_views(views);
  whole.status = MeasurementStatus::Rejected;
  if (!mean) {
    whole.reason = "the four views are of slots that leave one coordinate open";
    return answer(request, whole);
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    const double limit_mm = options_.four_view_limit.in_mm() + kGateSigmas * mean->sigma_mm[k];
    if (mean->residual_mm[k] <= limit_mm) continue;
    whole.reason = fmt::format(
        "the four marks disagree: they are {} mm from where the others have "
        "them, limit {:.4f} mm",
        numbers_of(*mean),
        limit_mm);
    return answer(request, whole);
  }
  whole.status = MeasurementStatus::Found;
  whole.place = {request.expected + displacement_mm<frame::Actual>(mean->deviation_mm),
                 mean->cov_mm2};
  whole.by_camera = mean->by_camera;
  return answer(request, whole);
}

Expected<Measurement> VisionProcedure::measure(const MeasurementRequest& request,
                                               ViewTaker& taker) {
  PANELCAL_CHECK(locator_.check(request));
  return request.settings.delta ? measure_four(request, taker) : measure_one(request, taker);
}

Expected<std::optional<FocusResult>> VisionProcedure::focus(const MeasurementRequest& request,
                                                            ViewTaker& taker) {
  if (!options_.focus_range) return std::nullopt;
  PANELCAL_CHECK(locator_.camera_of(request));
  PANELCAL_TRY(FocusResult result, autofocus(request, *options_.focus_range, taker));
  if (result.is_found) focus_z_ = result.z;
  return std::optional(std::move(result));
}

}  // namespace panelcal
