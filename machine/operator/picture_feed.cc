// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/picture_feed.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/correction/spindle_camera.h"
#include "vision/locate/focus.h"
#include "vision/picture/files/image_io.h"
#include <Eigen/Eigenvalues>

namespace panelcal::internal {
namespace {

/// A screen shows no more.
constexpr int kMaxShown_px = 1600;
/// Nodes of an outline that a drawing can tell apart.
constexpr std::size_t kMaxOutlineNodes = 120;

/// Empty for a picture that cannot be shown, which is no reason not to measure.
std::string shown_jpeg(const Image& image) {
  return encode_jpeg(image, kMaxShown_px).value_or(std::string());
}

std::vector<Eigen::Vector2d> first_outline(const TargetFit& best) {
  std::vector<Eigen::Vector2d> out;
  if (best.outlines_px.empty()) return out;
  const std::vector<Eigen::Vector2d>& outline_px = best.outlines_px.front();
  const std::size_t stride = outline_px.size() / kMaxOutlineNodes + 1;
  for (std::size_t i = 0; i < outline_px.size(); i += stride) {
    if (outline_px[i].allFinite()) out.push_back(outline_px[i]);
  }
  return out;
}

std::optional<ScreenEllipse> ellipse_of(const PositionEstimate<frame::Image>& center) {
  if (!center.cov.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(center.cov);
  const Eigen::Vector2d variance_px2 = axes.eigenvalues().cwiseMax(0);
  const Eigen::Vector2d longest = axes.eigenvectors().col(1);
  return ScreenEllipse{center.position.in_px(),
                       {std::sqrt(variance_px2(1)), std::sqrt(variance_px2(0))},
                       std::atan2(longest.y(), longest.x())};
}

}  // namespace

PositionEstimate<frame::Actual> ShownPicture::place_of(const Eigen::Vector2d& at_px,
                                                       double sigma_px) const {
  const auto u = position_px(at_px.x(), at_px.y());
  const Eigen::Vector2d seen_mm =
      camera.tilted ? camera.tilted->model(u).in_mm() : camera.mapping(u).in_mm();
  const Eigen::Matrix2d mm_from_px =
      camera.tilted ? camera.tilted->model.jacobian(u) : camera.mapping.jacobian(u);
  const Displacement<frame::Machine> from_zero =
      machine_from_optical(axis, position_mm<frame::Optical>(seen_mm)) - request.work_zero;
  Eigen::Matrix2d cov_mm2 = sigma_px * sigma_px * mm_from_px * mm_from_px.transpose();
  cov_mm2(1, 0) = cov_mm2(0, 1);
  return {position_mm<frame::Actual>(from_zero.in_mm()), cov_mm2};
}

CameraJacobian ShownPicture::by_camera(const Eigen::Vector2d& at_px) const {
  return camera.by_calibration(position_px(at_px.x(), at_px.y()));
}

std::optional<Eigen::Vector2d> ShownPicture::pixel_of(const Position<frame::Actual>& place) const {
  const auto in_machine = request.work_zero + displacement_mm<frame::Machine>(place.in_mm());
  const auto pixel = camera.pixel_of(in_machine, axis);
  return pixel ? std::optional<Eigen::Vector2d>(pixel->in_px()) : std::nullopt;
}

ScreenView PictureFeed::view_of(const ShownPicture& shown, const Image& image) const {
  ScreenView view;
  view.width_px = image.width();
  view.height_px = image.height();
  view.um_per_px = 1e3 * shown.camera.mapping.parameters().scale_mm_per_px;
  view.place_mm = (shown.axis - shown.request.work_zero).in_mm();
  const std::optional<double>& lamp = shown.request.settings.lamp;
  view.lamp = lamp ? lamp : vision_.lamp;
  return view;
}

double jog_limit_mm(const VisionOptions& vision) {
  constexpr double kUsualJog_mm = 5;
  return vision.search_radius ? vision.search_radius->in_mm() : kUsualJog_mm;
}

void PictureFeed::put(ShownPicture shown, const Image& image, ScreenView view) {
  shown_ = std::move(shown);
  jpeg_ = shown_jpeg(image);
  desk_.show(jpeg_, std::move(view));
}

void PictureFeed::see(const SeenView& seen) {
  ShownPicture shown{
      seen.request, seen.view, seen.picture.axis, seen.camera, seen.picture.name, {}};
  for (const Candidate& one : seen.detection.candidates) {
    shown.candidates.push_back({one.center.in_px(), one.size.in_px(), one.score});
  }
  const Image& image = seen.picture.image;
  ScreenView view = view_of(shown, image);
  const bool searches = seen.request.settings.search.value_or(false);
  const auto middle = shown.camera.pixel_of(
      searches ? seen.request.expected_in_machine() : seen.view.axis, shown.axis);
  if (middle) view.search_px = middle->in_px();
  std::optional<Length> radius = vision_.search_radius;
  if (searches) {
    radius =
        seen.request.settings.search_area ? seen.request.settings.search_area : vision_.search_area;
  }
  if (middle && radius) view.search_radius_px = 1e3 * radius->in_mm() / view.um_per_px;
  if (const std::optional<TargetFit>& best = seen.detection.best) {
    view.outline_px = first_outline(*best);
    view.ellipse = ellipse_of(best->center);
    view.contrast = std::abs(best->contrast) / image.full_scale();
    view.sharpness = std::clamp(1 - best->blur_px / max_blur_px_, 0.0, 1.0);
  }
  put(std::move(shown), image, std::move(view));
}

void PictureFeed::show(const MeasurementRequest& request,
                       const View& view,
                       const TakenPicture& picture,
                       const ZoomedCamera& camera) {
  ShownPicture shown{request, view, picture.axis, camera, picture.name, {}};
  if (shown_) shown.candidates = shown_->candidates;
  ScreenView screen = view_of(shown, picture.image);
  put(std::move(shown), picture.image, std::move(screen));
}

void show_plain(Desk& desk, const Image& image) {
  ScreenView view;
  view.width_px = image.width();
  view.height_px = image.height();
  desk.show(shown_jpeg(image), std::move(view));
}

}  // namespace panelcal::internal
