// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/overlay.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <span>

#include <opencv2/imgproc.hpp>

#include "panelcal/vision/cv_bridge.h"

namespace panelcal {
namespace {

/// OpenCV draws at fractions of a pixel in fixed point.
constexpr int kFractionBits = 8;
constexpr int kMaxZoom = 16;
constexpr int kMaxSide = 4096;

const cv::Scalar kGreen(60, 200, 60);
const cv::Scalar kRed(60, 60, 230);
const cv::Scalar kYellow(0, 200, 230);

/// The piece of picture that is shown and how it is enlarged.
struct View {
  cv::Rect box;
  int zoom = 1;

  /// A place of the picture in the enlarged piece: pixel centres stay pixel centres.
  cv::Point fixed(const Eigen::Vector2d& u_px) const {
    return {fixed((u_px.x() - box.x + 0.5) * zoom - 0.5),
            fixed((u_px.y() - box.y + 0.5) * zoom - 0.5)};
  }
  static int fixed(double v) {
    // Places far outside must not overflow; they are cut off anyway.
    return static_cast<int>(std::lround(std::clamp(v, -1e5, 1e5) * (1 << kFractionBits)));
  }
};

View view_of(const Image& image, const Detection& detection, const OverlayOptions& options) {
  const cv::Rect whole(0, 0, image.width(), image.height());
  View view{whole, 1};
  if (detection.best) {
    const Eigen::Vector2d& u = detection.best->center.position.in_px();
    const double half =
        options.half_width ? options.half_width->in_px() : detection.best->size.in_px() + 8;
    const auto clamped = [](double v, int end) {
      return static_cast<int>(std::lround(std::clamp(v, 0.0, static_cast<double>(end))));
    };
    const cv::Point first(clamped(u.x() - half, whole.width), clamped(u.y() - half, whole.height));
    const cv::Point last(clamped(u.x() + half + 1, whole.width),
                         clamped(u.y() + half + 1, whole.height));
    const cv::Rect box(first, last);
    if (!box.empty()) view.box = box;
  }
  const int side = std::max(view.box.width, view.box.height);
  view.zoom = std::clamp((options.min_side + side - 1) / side, 1, kMaxZoom);
  if (side * view.zoom > kMaxSide) view.zoom = 1;
  return view;
}

/// Grey levels spread to 8 bit as they are: a report must not make a faint target look clear.
cv::Mat enlarged(const Image& image, const View& view) {
  cv::Mat grey;
  internal::mat_of(image)(view.box).convertTo(grey, CV_8U, Image::kFullScale8 / image.full_scale());
  cv::Mat large;
  const cv::Size size(view.box.width * view.zoom, view.box.height * view.zoom);
  cv::resize(grey, large, size, 0, 0, cv::INTER_NEAREST);
  cv::Mat color;
  cv::cvtColor(large, color, cv::COLOR_GRAY2BGR);
  return color;
}

void draw_rim(cv::Mat& picture,
              const View& view,
              const Eigen::Vector2d& center_px,
              PixelLength diameter,
              const cv::Scalar& color) {
  const int radius = View::fixed(0.5 * diameter.in_px() * view.zoom);
  if (radius <= 0) return;
  cv::circle(picture, view.fixed(center_px), radius, color, 1, cv::LINE_AA, kFractionBits);
}

void draw_cross(cv::Mat& picture,
                const View& view,
                const Eigen::Vector2d& center_px,
                double arm_px,
                const cv::Scalar& color) {
  for (const Eigen::Vector2d& arm : {Eigen::Vector2d(arm_px, 0), Eigen::Vector2d(0, arm_px)}) {
    const Eigen::Vector2d from = center_px - arm;
    const Eigen::Vector2d to = center_px + arm;
    cv::line(picture, view.fixed(from), view.fixed(to), color, 1, cv::LINE_AA, kFractionBits);
  }
}

void draw(cv::Mat& picture, const View& view, const Detection& detection) {
  for (const Candidate& other : detection.candidates) {
    if (detection.best && other.center == detection.best->center.position) continue;
    draw_rim(picture, view, other.center.in_px(), other.size, kYellow);
  }
  if (!detection.best) return;
  const TargetFit& best = *detection.best;
  const cv::Scalar& color = detection.status == DetectionStatus::Found ? kGreen : kRed;
  const Eigen::Vector2d& u = best.center.position.in_px();
  draw_rim(picture, view, u, best.size, color);
  if (best.inner_size) draw_rim(picture, view, u, *best.inner_size, color);
  draw_cross(picture, view, u, std::max(3.0, 0.2 * best.size.in_px()), color);
}

}  // namespace

Expected<std::string> encode_overlay(const Image& image,
                                     const Detection& detection,
                                     const OverlayOptions& options) {
  if (image.empty()) {
    return failure({Code::PictureFormat, {}, "an empty picture cannot be shown", "a picture"});
  }
  try {
    const View view = view_of(image, detection, options);
    cv::Mat picture = enlarged(image, view);
    draw(picture, view, detection);
    return internal::png_of(picture);
  } catch (const std::exception& e) {
    return failure({Code::Internal, {}, std::string("drawing failed: ") + e.what(), ""});
  }
}

}  // namespace panelcal
