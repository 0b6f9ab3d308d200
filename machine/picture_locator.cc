// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/picture_locator.h"

#include <algorithm>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "panelcal/calib/spindle_camera.h"

namespace panelcal {
namespace {

MeasurementStatus status_of(DetectionStatus status) {
  switch (status) {
    case DetectionStatus::Found:
      return MeasurementStatus::Found;
    case DetectionStatus::NotFound:
      return MeasurementStatus::NotFound;
    case DetectionStatus::Ambiguous:
      return MeasurementStatus::Ambiguous;
    case DetectionStatus::Rejected:
      return MeasurementStatus::Rejected;
  }
  return MeasurementStatus::Rejected;
}

std::string point_text(const Position<frame::Machine>& p) {
  return fmt::format("({:.4f}, {:.4f}) mm", p.in_mm().x(), p.in_mm().y());
}

/// How a picture is called in messages.
std::string name_of(const TakenPicture& picture) {
  return picture.name.empty() ? "the picture" : "picture " + quoted(picture.name);
}

/// The weighted mean of measurements, built up one at a time.
class Average {
 public:
  void add(const PositionEstimate<frame::Actual>& estimate) {
    if (n_ == 0) first_ = estimate;
    const Eigen::Matrix2d weight = estimate.cov.inverse();
    // About the first one, so that no digits are lost far from work zero.
    const Displacement<frame::Actual> offset = estimate.position - first_.position;
    weight_ += weight;
    weighted_ += weight * offset.in_mm();
    ++n_;
  }
  PositionEstimate<frame::Actual> result() const {
    // A single measurement stays what it is, to the bit.
    if (n_ == 1) return first_;
    const Eigen::Matrix2d cov = weight_.inverse();
    const Eigen::Vector2d offset_mm = cov * weighted_;
    return {first_.position + displacement_mm<frame::Actual>(offset_mm),
            0.5 * (cov + cov.transpose())};
  }

 private:
  int n_ = 0;
  PositionEstimate<frame::Actual> first_;
  Eigen::Matrix2d weight_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d weighted_ = Eigen::Vector2d::Zero();
};

}  // namespace

std::string describe(const MeasurementRequest& request) {
  return fmt::format("{} target {} (line {})", request.command, request.seq, request.line);
}

Expected<PictureLocator> PictureLocator::create(const MachineConfig& config,
                                                PictureObserver observer) {
  if (!config.camera) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "there is no [camera], so that pictures cannot be brought to mm",
                    "[camera] calibration"});
  }
  return PictureLocator(config, std::move(observer));
}

PictureLocator::PictureLocator(const MachineConfig& config, PictureObserver observer)
    : config_file_(config.file),
      mapping_(config.camera->mapping()),
      width_px_(config.camera->picture_width_px),
      height_px_(config.camera->picture_height_px),
      locate_(config.locate),
      vision_tools_(config.vision_tools),
      observer_(std::move(observer)) {
  if (config.search_radius) {
    locate_.search_radius =
        px(config.search_radius->in_mm() / mapping_.parameters().scale_mm_per_px);
  }
}

Expected<Target> PictureLocator::target_of(const MeasurementRequest& request) const {
  const VisionSettings& settings = request.settings;
  const Place place{config_file_.string(), 0, 0};
  if (settings.delta || settings.tools.size() > 1) {
    return failure(
        {Code::NotSupported,
         place,
         describe(request) + " is a large target seen in four views (G34 with a distance)",
         "a target that one picture shows"});
  }
  const int number = settings.tools.empty() ? 0 : settings.tools.front();
  const auto found = vision_tools_.find(number);
  if (found != vision_tools_.end()) return found->second;
  return failure({Code::VisionToolUndefined,
                  place,
                  fmt::format("{} asks for vision tool {}", describe(request), number),
                  fmt::format("a [[vision.tool]] with number = {}", number)});
}

std::optional<Position<frame::Image>> PictureLocator::pixel_of(
    const Position<frame::Machine>& place, const Position<frame::Machine>& axis) const {
  const auto pixel = mapping_.image_of(position_mm<frame::Optical>((place - axis).in_mm()));
  if (!pixel) return std::nullopt;
  const double x_px = pixel->in_px().x();
  const double y_px = pixel->in_px().y();
  const bool is_inside =
      x_px >= -0.5 && x_px <= width_px_ - 0.5 && y_px >= -0.5 && y_px <= height_px_ - 0.5;
  return is_inside ? pixel : std::nullopt;
}

Expected<Position<frame::Image>> PictureLocator::check_picture(const MeasurementRequest& request,
                                                               const TakenPicture& picture) const {
  const Image& image = picture.image;
  if (image.width() != width_px_ || image.height() != height_px_) {
    return failure(
        {Code::PictureMismatch,
         {picture.path, 0, 0},
         fmt::format("{} has {} x {} px", name_of(picture), image.width(), image.height()),
         fmt::format("{} x {} px, for which [camera] is calibrated", width_px_, height_px_)});
  }
  const Position<frame::Machine> expected = request.expected_in_machine();
  if (const auto pixel = pixel_of(expected, picture.axis)) return *pixel;
  return failure({Code::PictureMissing,
                  {picture.path, 0, 0},
                  fmt::format("{} was taken at {} and does not show {}",
                              name_of(picture),
                              point_text(picture.axis),
                              describe(request)),
                  "a picture of " + point_text(expected)});
}

Expected<Measurement> PictureLocator::measure_one(const MeasurementRequest& request,
                                                  const Target& target,
                                                  const TakenPicture& picture) const {
  PANELCAL_TRY(const Position<frame::Image> expected_px, check_picture(request, picture));
  LocateOptions options = locate_;
  if (options.search_radius) options.search_center = expected_px;
  const Detection detection = locate(picture.image, target, &mapping_, options);
  if (observer_) observer_(request, picture.image, detection);

  Measurement measurement{.request = request, .status = status_of(detection.status)};
  measurement.image = picture.name;
  measurement.reason = detection.reason;
  if (detection.best) measurement.score = detection.best->score;
  if (measurement.status != MeasurementStatus::Found) return measurement;
  const PositionEstimate<frame::Optical>& seen = *detection.best->center_optical;
  const Displacement<frame::Machine> from_work_zero =
      machine_from_optical(picture.axis, seen.position) - request.work_zero;
  measurement.measured = {position_mm<frame::Actual>(from_work_zero.in_mm()), seen.cov};
  return measurement;
}

Expected<Measurement> PictureLocator::measure(const MeasurementRequest& request,
                                              int n_pictures,
                                              const NextPicture& next) const {
  PANELCAL_TRY(const Target target, target_of(request));
  Average average;
  std::optional<Measurement> whole;
  for (int i = 0; i < n_pictures; ++i) {
    PANELCAL_TRY(const TakenPicture picture, next(i));
    PANELCAL_TRY(Measurement one, measure_one(request, target, picture));
    if (one.status != MeasurementStatus::Found) {
      if (n_pictures > 1) {
        one.reason = fmt::format("{} of {} pictures: {}", i + 1, n_pictures, one.reason);
      }
      return one;
    }
    average.add(one.measured);
    const double least_score = std::min(*one.score, whole ? *whole->score : *one.score);
    if (!whole) whole = std::move(one);
    whole->score = least_score;
  }
  whole->measured = average.result();
  return *whole;
}

}  // namespace panelcal
