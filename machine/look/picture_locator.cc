// SPDX-License-Identifier: Apache-2.0
#include "machine/look/picture_locator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/base/statistics/covariance_check.h"
#include "calib/camera/circle_bias.h"
#include "calib/correction/spindle_camera.h"
#include <Eigen/LU>
#include <fmt/format.h>

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

std::string machine_point_text(const Position<frame::Machine>& p) {
  return fmt::format("({:.4f}, {:.4f}) mm", p.in_mm().x(), p.in_mm().y());
}

/// Name of a picture in messages.
std::string looked_at_name(const TakenPicture& picture) {
  return picture.name.empty() ? "the picture" : "picture " + quoted(picture.name);
}

/// A slot tells where its middle line runs and nothing along it, so its place is taken beside the
/// expected one; going there along a line of uncertain direction adds to the uncertainty.
void bring_beside(const Eigen::Vector2d& expected_mm, double angle_sigma_rad, Sight& sight) {
  const Eigen::Vector2d& along = *sight.blind;
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d& seen_mm = sight.place.position.in_mm();
  const double way_mm = along.dot(expected_mm - seen_mm);
  const double variance_mm2 =
      across.dot(sight.place.cov * across) + std::pow(way_mm * angle_sigma_rad, 2);
  const double along_mm2 = along.dot(sight.place.cov * along);
  const Eigen::Vector2d foot_mm = seen_mm + way_mm * along;
  sight.place.position = position_mm<frame::Actual>(foot_mm);
  sight.place.cov =
      variance_mm2 * across * across.transpose() + along_mm2 * along * along.transpose();
}

ZoomedCamera camera_from(const CameraCalibration& calibration) {
  ZoomedCamera camera{
      calibration.mapping(), calibration.picture_width_px, calibration.picture_height_px};
  if (calibration.needs_model()) {
    camera.tilted = TiltedCamera{calibration.model(), SharedCameraError(calibration)};
  }
  return camera;
}

bool is_round(Shape shape) {
  return shape == Shape::Disc || shape == Shape::Hole || shape == Shape::Ring;
}

/// The place that a full camera sees a fitted target at; empty past the rim of what it sees.
std::optional<PositionEstimate<frame::Optical>> seen_through(const TiltedCamera& camera,
                                                             const CameraMapping& mapping,
                                                             const Target& target,
                                                             PositionEstimate<frame::Image> center,
                                                             const std::optional<Length>& size) {
  if (!camera.model.sees(center.position)) return std::nullopt;
  if (is_round(target.shape) && size) {
    const Length radius = 0.5 * *size;
    const CameraModel known(mapping.parameters());
    center.position = center.position - (circle_bias(camera.model, center.position, radius) -
                                         circle_bias(known, center.position, radius));
  }
  if (!camera.model.sees(center.position)) return std::nullopt;
  PositionEstimate<frame::Optical> seen = camera.model(center);
  seen.cov += camera.error.rest_mm2(center.position);
  return seen;
}

/// Corners of the area in which a picture shows all of a target with some of its surroundings;
/// empty in a small picture.
std::optional<std::array<Position<frame::Optical>, 4>> listed_corners(const ZoomedCamera& camera,
                                                                      const Target& target) {
  constexpr double kSurroundings_px = 6;
  const double margin_px =
      outer_radius(target, camera.mapping).in_mm() / camera.mapping.parameters().scale_mm_per_px +
      kSurroundings_px;
  const double right_px = camera.width_px - 1 - margin_px;
  const double bottom_px = camera.height_px - 1 - margin_px;
  if (!(right_px > margin_px) || !(bottom_px > margin_px)) return std::nullopt;
  const auto seen = [&](double x_px, double y_px) {
    const Position<frame::Image> u = position_px(x_px, y_px);
    return camera.tilted ? camera.tilted->model(u) : camera.mapping(u);
  };
  return std::array{seen(margin_px, margin_px),
                    seen(right_px, margin_px),
                    seen(right_px, bottom_px),
                    seen(margin_px, bottom_px)};
}

/// A direction that was fitted in the simple form.
Eigen::Vector2d direction_through(const ZoomedCamera& camera,
                                  const Position<frame::Image>& u,
                                  const Eigen::Vector2d& direction) {
  if (!camera.tilted) return direction;
  return (camera.tilted->model.jacobian(u) * camera.mapping.jacobian(u).inverse() * direction)
      .normalized();
}

/// Of a trace whose fit has no covariance: 10 um.
constexpr double kTraceVariance_mm2 = 1e-4;

KnownDetection question(const MeasurementRequest& request,
                        const Look& look,
                        const LocateOptions& options) {
  return {
      look.target.number, request.settings.zoom, options.search_center, options.search_radius, {}};
}

bool is_same_question(const KnownDetection& a, const KnownDetection& b) {
  const bool is_same_area =
      a.search_center.has_value() == b.search_center.has_value() &&
      (!a.search_center || (a.search_center->in_px() == b.search_center->in_px() &&
                            a.search_radius->in_px() == b.search_radius->in_px()));
  return a.tool == b.tool && a.zoom == b.zoom && is_same_area;
}

}  // namespace

std::string describe(const MeasurementRequest& request) {
  if (request.seq < 0) return fmt::format("{} (line {})", request.command, request.line);
  return fmt::format("{} target {} (line {})", request.command, request.seq, request.line);
}

std::optional<Position<frame::Image>> ZoomedCamera::image_of(
    const Position<frame::Optical>& place) const {
  return tilted ? tilted->model.image_of(place) : mapping.image_of(place);
}

CameraJacobian ZoomedCamera::by_calibration(const Position<frame::Image>& pixel) const {
  return tilted ? tilted->error.by(pixel) : mapping.by_parameters(pixel);
}

std::optional<Position<frame::Image>> ZoomedCamera::pixel_of(
    const Position<frame::Machine>& place, const Position<frame::Machine>& axis) const {
  const auto pixel = image_of(position_mm<frame::Optical>((place - axis).in_mm()));
  if (!pixel) return std::nullopt;
  const double x_px = pixel->in_px().x();
  const double y_px = pixel->in_px().y();
  const bool is_inside =
      x_px >= -0.5 && x_px <= width_px - 0.5 && y_px >= -0.5 && y_px <= height_px - 0.5;
  return is_inside ? pixel : std::nullopt;
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
      camera_(camera_from(*config.camera)),
      algorithms_(config.vision.algorithms),
      locate_(config.locate),
      vision_tools_(config.vision_tools),
      observer_(std::move(observer)) {
  for (const auto& [level, calibration] : config.zooms) {
    zooms_.emplace(level, camera_from(calibration));
  }
}

Expected<Target> PictureLocator::target_of(const MeasurementRequest& request, int i_tool) const {
  const std::vector<int>& tools = request.settings.tools;
  const auto i = static_cast<std::size_t>(i_tool);
  const int number = i < tools.size() ? tools[i] : 0;
  const auto found = vision_tools_.find(number);
  if (found != vision_tools_.end()) return found->second;
  return failure({Code::VisionToolUndefined,
                  {config_file_.string(), 0, 0},
                  fmt::format("{} asks for vision tool {}", describe(request), number),
                  fmt::format("a [[vision.tool]] with number = {}", number)});
}

Expected<ZoomedCamera> PictureLocator::camera_of(const MeasurementRequest& request) const {
  const std::optional<double>& zoom = request.settings.zoom;
  if (!zoom) return camera_;
  const auto found = zooms_.find(*zoom);
  if (found != zooms_.end()) return found->second;
  return failure(
      {Code::ConfigValue,
       {config_file_.string(), 0, 0},
       fmt::format(
           "{} is seen at zoom {}, for which no camera is calibrated", describe(request), *zoom),
       fmt::format("[[camera.zoom]] with level = {}", *zoom)});
}

Expected<void> PictureLocator::check_tools(const MeasurementRequest& request) const {
  const std::size_t n_tools = request.settings.tools.size();
  const bool is_four = request.settings.delta.has_value();
  if (n_tools > 1 && (n_tools != 4 || !is_four)) {
    return failure({Code::NotSupported,
                    {},
                    fmt::format("{} has {} vision tools{}",
                                describe(request),
                                n_tools,
                                is_four ? "" : " and no distance of views"),
                    "one vision tool, or four with a distance"});
  }
  for (std::size_t i = 0; i < std::max<std::size_t>(1, n_tools); ++i) {
    PANELCAL_TRY(const Target target, target_of(request, static_cast<int>(i)));
    if (target.shape != Shape::Slot || is_four || request.axes != ObservedAxes::Both) continue;
    return failure({Code::TargetInvalid,
                    {config_file_.string(), 0, 0},
                    fmt::format("{} asks for both coordinates, and vision tool {} is a slot, which "
                                "shows one",
                                describe(request),
                                target.number),
                    "measurement mode 5, four views, or a vision tool of another shape"});
  }
  return {};
}

Expected<void> PictureLocator::check(const MeasurementRequest& request) const {
  const int n = request.settings.inspections;
  if (n > kMaxInspections) {
    return failure({Code::NotSupported,
                    {},
                    fmt::format("{} asks for {} inspections", describe(request), n),
                    fmt::format("at most {}", kMaxInspections)});
  }
  const std::optional<int>& algorithm = request.settings.algorithm;
  if (algorithm && std::ranges::find(algorithms_, *algorithm) == algorithms_.end()) {
    return failure({Code::NotSupported,
                    {config_file_.string(), 0, 0},
                    fmt::format("{} asks for vision algorithm {}", describe(request), *algorithm),
                    fmt::format("{} ([vision] algorithms)", fmt::join(algorithms_, ", "))});
  }
  PANELCAL_CHECK(check_tools(request));
  PANELCAL_CHECK(camera_of(request));
  return {};
}

Length outer_radius(const Target& target, const CameraMapping& mapping) {
  const double scale_mm = mapping.parameters().scale_mm_per_px;
  const double unit_mm = target.size ? 1 : scale_mm;
  const double size_mm = target.size ? target.size->in_mm() : target.size_px->in_px() * scale_mm;
  constexpr double kDiagonal = 0.7071;
  switch (target.shape) {
    case Shape::Square:
    case Shape::Diamond:
      return mm(kDiagonal * size_mm);
    case Shape::AprilTag:
      // The white border that most families have around the corners' square, and some to spare.
      return mm(1.5 * kDiagonal * size_mm);
    case Shape::Dots: {
      double reach = 0;
      for (const Eigen::Vector2d& dot : target.dots) reach = std::max(reach, dot.norm());
      return mm(reach * unit_mm + size_mm / 2);
    }
    case Shape::Template: {
      const Image& image = target.picture->image;
      const double height_mm = size_mm * image.height() / std::max(1, image.width());
      // Its place may be at its very corner.
      return mm(std::hypot(size_mm, height_mm));
    }
    default:
      return mm(size_mm / 2);
  }
}

Expected<void> PictureLocator::check_picture(const MeasurementRequest& request,
                                             const Look& look,
                                             const TakenPicture& picture,
                                             const ZoomedCamera& camera) const {
  const Image& image = picture.image;
  if (image.width() != camera.width_px || image.height() != camera.height_px) {
    return failure(
        {Code::PictureMismatch,
         {picture.path, 0, 0},
         fmt::format("{} has {} x {} px", looked_at_name(picture), image.width(), image.height()),
         fmt::format(
             "{} x {} px, for which [camera] is calibrated", camera.width_px, camera.height_px)});
  }
  if (camera.pixel_of(look.shown, picture.axis)) return {};
  return failure({Code::PictureMissing,
                  {picture.path, 0, 0},
                  fmt::format("{} was taken at {} and does not show {}{}",
                              looked_at_name(picture),
                              machine_point_text(picture.axis),
                              describe(request),
                              look.words),
                  "a picture of " + machine_point_text(look.shown)});
}

void PictureLocator::list_candidates(const MeasurementRequest& request,
                                     const Look& look,
                                     const TakenPicture& picture,
                                     const ZoomedCamera& camera,
                                     const Detection& detection,
                                     Sight& sight) const {
  if (look.target.shape == Shape::Slot) return;
  const auto at = [&](const Position<frame::Optical>& seen) {
    const Displacement<frame::Machine> from_work_zero =
        machine_from_optical(picture.axis, seen) - request.work_zero;
    return position_mm<frame::Actual>(from_work_zero.in_mm());
  };
  for (const Candidate& candidate : detection.candidates) {
    std::optional<PositionEstimate<frame::Optical>> seen = candidate.center_optical;
    if (camera.tilted) {
      seen = seen_through(*camera.tilted,
                          camera.mapping,
                          look.target,
                          {candidate.center, candidate.cov_px2},
                          candidate.size_mm);
    }
    // A fit that did not converge has no covariance; it is a trace all the same.
    const bool is_usable = seen && seen->position.in_mm().allFinite();
    if (!is_usable) continue;
    if (!internal::is_measured_covariance(seen->cov)) {
      if (candidate.counts) continue;
      seen->cov = kTraceVariance_mm2 * Eigen::Matrix2d::Identity();
    }
    seen->cov(1, 0) = seen->cov(0, 1);
    sight.candidates.push_back({{at(seen->position), seen->cov},
                                std::clamp(candidate.score, 0.0, 1.0),
                                candidate.counts,
                                camera.by_calibration(candidate.center)});
  }
  const auto corners = listed_corners(camera, look.target);
  if (!detection.lists_all || !corners) return;
  sight.listed.emplace();
  std::ranges::transform(*corners, sight.listed->corners.begin(), at);
  // The views of a search go on until the target is found, wherever it is.
  if (!request.settings.search.value_or(false)) sight.listed->radius = look.radius;
}

LocateOptions PictureLocator::options_of(const Look& look,
                                         const TakenPicture& picture,
                                         const ZoomedCamera& camera) const {
  LocateOptions options = locate_;
  const auto center =
      camera.image_of(position_mm<frame::Optical>((look.expected - picture.axis).in_mm()));
  if (look.radius && center) {
    options.search_center = *center;
    options.search_radius = px(look.radius->in_mm() / camera.mapping.parameters().scale_mm_per_px);
  }
  return options;
}

std::optional<KnownDetection> PictureLocator::look_ahead(const MeasurementRequest& request,
                                                         const Look& look,
                                                         const TakenPicture& picture) const {
  const auto camera = camera_of(request);
  if (!camera || !check_picture(request, look, picture, *camera)) return std::nullopt;
  const LocateOptions options = options_of(look, picture, *camera);
  KnownDetection known = question(request, look, options);
  known.detection = locate(picture.image, look.target, &camera->mapping, options);
  return known;
}

Expected<Sight> PictureLocator::look(const MeasurementRequest& request,
                                     const Look& look,
                                     const TakenPicture& picture,
                                     bool is_observed) const {
  PANELCAL_TRY(const ZoomedCamera camera, camera_of(request));
  PANELCAL_CHECK(check_picture(request, look, picture, camera));
  const LocateOptions options = options_of(look, picture, camera);
  const bool is_known =
      picture.known && is_same_question(*picture.known, question(request, look, options));
  const Detection detection = is_known
                                  ? picture.known->detection
                                  : locate(picture.image, look.target, &camera.mapping, options);
  if (is_observed && observer_) observer_({request, look.view, picture, camera, detection});

  Sight sight;
  sight.status = status_of(detection.status);
  sight.reason = detection.reason;
  sight.image = picture.name;
  if (detection.best) sight.score = std::clamp(detection.best->score, 0.0, 1.0);
  list_candidates(request, look, picture, camera, detection, sight);
  if (!sight.is_found()) return sight;
  const Position<frame::Image>& center_px = detection.best->center.position;
  PositionEstimate<frame::Optical> seen = *detection.best->center_optical;
  if (camera.tilted) {
    const TargetFit& best = *detection.best;
    const auto through =
        seen_through(*camera.tilted, camera.mapping, look.target, best.center, best.size_mm);
    if (!through) {
      sight.status = MeasurementStatus::Rejected;
      sight.reason = "target outside the calibrated field";
      return sight;
    }
    seen = *through;
  }
  const Displacement<frame::Machine> from_work_zero =
      machine_from_optical(picture.axis, seen.position) - request.work_zero;
  sight.place = {position_mm<frame::Actual>(from_work_zero.in_mm()), seen.cov};
  sight.by_camera = camera.by_calibration(center_px);
  if (const auto blind = detection.best->blind_direction) {
    const Eigen::Vector2d fitted(std::cos(blind->in_rad()), std::sin(blind->in_rad()));
    sight.blind = direction_through(camera, center_px, fitted);
    bring_beside(
        (look.expected - request.work_zero).in_mm(), detection.best->angle_sigma.in_rad(), sight);
    const Eigen::Vector2d foot_mm = request.work_zero.in_mm() + sight.place.position.in_mm();
    const auto pixel =
        camera.image_of(position_mm<frame::Optical>((foot_mm - picture.axis.in_mm()).eval()));
    if (pixel) sight.by_camera = camera.by_calibration(*pixel);
    const Eigen::Vector2d across(-sight.blind->y(), sight.blind->x());
    sight.by_camera = (across * across.transpose() * sight.by_camera).eval();
  }
  return sight;
}

}  // namespace panelcal
