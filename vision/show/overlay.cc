// SPDX-License-Identifier: Apache-2.0
#include "vision/show/overlay.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <vector>

#include "vision/picture/cv_bridge.h"
#include "vision/picture/formats/png_codec.h"
#include "vision/picture/memory_error.h"
#include "vision/show/overlay_legend.h"
#include "vision/show/overlay_panel.h"
#include "vision/show/shown_box.h"
#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace panelcal {
namespace {

using internal::Ink;
using internal::kFractionBits;

constexpr int kMaxZoom = 16;
/// Larger pieces are scaled down to this side: no screen shows 100 megapixels at once.
constexpr int kMaxOverlaySide = 2048;
constexpr int kLeastLegendWidth = 400;

/// The piece of picture that is shown, and how many pixels here are one of the picture.
struct View {
  cv::Rect box;
  double zoom = 1;

  /// A place of the picture in the enlarged piece: pixel centres stay pixel centres.
  Eigen::Vector2d at(const Eigen::Vector2d& u_px) const {
    return zoom * (u_px - Eigen::Vector2d(box.x, box.y) + Eigen::Vector2d(0.5, 0.5)) -
           Eigen::Vector2d(0.5, 0.5);
  }
  cv::Point fixed(const Eigen::Vector2d& u_px) const {
    const Eigen::Vector2d v = at(u_px);
    return internal::fixed_point(v.x(), v.y());
  }
  cv::Size size() const {
    const auto scaled = [&](int n) { return std::max(1, static_cast<int>(std::lround(zoom * n))); };
    return {scaled(box.width), scaled(box.height)};
  }
};

using Outlines = std::vector<std::vector<Eigen::Vector2d>>;

View overlay_view(const Image& image, const Detection& detection, const OverlayOptions& options) {
  View view{internal::shown_box(image, detection, options.half_width), 1};
  const int side = std::max(view.box.width, view.box.height);
  const int wanted = std::clamp(options.min_side, 1, kMaxOverlaySide);
  view.zoom = std::clamp((wanted + side - 1) / side, 1, kMaxZoom);
  if (side > kMaxOverlaySide) view.zoom = static_cast<double>(kMaxOverlaySide) / side;
  return view;
}

/// Grey levels spread to 8 bit as they are: a report must not make a faint target look clear.
cv::Mat enlarged(const Image& image, const View& view) {
  cv::Mat grey;
  internal::mat_of(image)(view.box).convertTo(grey, CV_8U, Image::kFullScale8 / image.full_scale());
  cv::Mat large;
  cv::resize(grey, large, view.size(), 0, 0, view.zoom < 1 ? cv::INTER_AREA : cv::INTER_NEAREST);
  cv::Mat color;
  cv::cvtColor(large, color, cv::COLOR_GRAY2BGR);
  return color;
}

/// Polygons are closed, but lines are not, and a gap is where they leave the picture.
bool is_closed(const std::vector<Eigen::Vector2d>& outline) {
  if (outline.size() < 3) return false;
  double longest = 0;
  for (std::size_t i = 1; i < outline.size(); ++i) {
    longest = std::max(longest, (outline[i] - outline[i - 1]).norm());
  }
  return (outline.front() - outline.back()).norm() <= 2 * longest;
}

/// Drawing into the enlarged piece.
class Drawing {
 public:
  Drawing(cv::Mat& picture, const View& view) : picture_(picture), view_(view) {}

  void circle(const Eigen::Vector2d& center_px, PixelLength diameter, Ink ink) {
    const double radius = 0.5 * diameter.in_px() * view_.zoom;
    // OpenCV walks along the whole circle, whatever part of it is seen.
    if (!(radius > 0) || radius > 1e4 || !center_px.allFinite()) return;
    cv::circle(picture_,
               view_.fixed(center_px),
               internal::fixed_point(radius, 0).x,
               picture_color(ink),
               1,
               cv::LINE_AA,
               kFractionBits);
  }

  /// A candidate's outlines, or a circle of its size where there are none.
  void outlines(const Outlines& outlines_px,
                const Eigen::Vector2d& center_px,
                PixelLength size,
                Ink ink) {
    if (outlines_px.empty()) circle(center_px, size, ink);
    for (const auto& outline : outlines_px) {
      std::vector<cv::Point> nodes;
      for (const Eigen::Vector2d& u : outline) {
        if (u.allFinite()) nodes.push_back(view_.fixed(u));
      }
      if (nodes.empty()) continue;
      cv::polylines(
          picture_, nodes, is_closed(outline), picture_color(ink), 1, cv::LINE_AA, kFractionBits);
    }
  }

  void cross(const Eigen::Vector2d& center_px, double arm, Ink ink) {
    if (!center_px.allFinite()) return;
    const double arm_px = arm / view_.zoom;
    for (const Eigen::Vector2d& v : {Eigen::Vector2d(arm_px, 0), Eigen::Vector2d(0, arm_px)}) {
      cv::line(picture_,
               view_.fixed(center_px - v),
               view_.fixed(center_px + v),
               picture_color(ink),
               1,
               cv::LINE_AA,
               kFractionBits);
    }
  }

  /// A candidate's number beside its middle, readable on any ground.
  void label(const Eigen::Vector2d& center_px, std::size_t number, Ink ink) {
    const Eigen::Vector2d at = view_.at(center_px);
    const bool is_inside =
        at.x() >= 0 && at.y() >= 0 && at.x() < picture_.cols && at.y() < picture_.rows;
    if (!is_inside) return;
    const std::string text = fmt::format("{}", number);
    int baseline = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, &baseline);
    const cv::Point corner(
        std::clamp(static_cast<int>(at.x()) + 5, 2, std::max(2, picture_.cols - size.width - 2)),
        std::clamp(static_cast<int>(at.y()) - 5,
                   size.height + 2,
                   std::max(size.height + 2, picture_.rows - 2)));
    for (const auto& [color, thickness] :
         {std::pair(cv::Scalar(0, 0, 0), 3), std::pair(picture_color(ink), 1)}) {
      cv::putText(
          picture_, text, corner, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, thickness, cv::LINE_AA);
    }
  }

 private:
  cv::Mat& picture_;
  const View& view_;
};

void draw(cv::Mat& picture,
          const View& view,
          const Detection& detection,
          const OverlayOptions& options) {
  Drawing drawing(picture, view);
  if (options.search_center && options.search_radius) {
    drawing.circle(options.search_center->in_px(), 2 * *options.search_radius, Ink::Quiet);
  }
  const auto others = other_candidates(detection);
  const auto ink = [&](const Candidate& c) {
    return detection.best && c.center == detection.best->center.position ? Ink::Bad : Ink::Other;
  };
  for (const Candidate& other : others) {
    drawing.outlines(other.outlines_px, other.center.in_px(), other.size, ink(other));
    drawing.cross(other.center.in_px(), 3, ink(other));
  }
  if (detection.best) {
    const TargetFit& best = *detection.best;
    const Eigen::Vector2d& u = best.center.position.in_px();
    const Ink best_ink = internal::ink_of(detection.status);
    drawing.outlines(best.outlines_px, u, best.size, best_ink);
    drawing.cross(u, std::clamp(0.2 * best.size.in_px() * view.zoom, 6.0, 20.0), best_ink);
    for (std::size_t i = 0; i < best.corners.size(); ++i) {
      drawing.label(best.corners[i].position.in_px(), i, best_ink);
    }
  }
  for (std::size_t i = 0; i < others.size(); ++i) {
    drawing.label(others[i].center.in_px(), i + 1, ink(others[i]));
  }
}

/// The legend under the picture, as wide as both need.
cv::Mat with_legend(const cv::Mat& picture, const Detection& detection, std::string_view title) {
  const int width = std::max(picture.cols, kLeastLegendWidth);
  const cv::Mat legend =
      internal::legend_panel(detection, internal::legend_of(detection, title), width);
  cv::Mat page(picture.rows + legend.rows, width, CV_8UC3, cv::Scalar::all(225));
  picture.copyTo(page(cv::Rect(0, 0, picture.cols, picture.rows)));
  legend.copyTo(page(cv::Rect(0, picture.rows, width, legend.rows)));
  return page;
}

}  // namespace

Expected<std::string> encode_overlay(const Image& image,
                                     const Detection& detection,
                                     const OverlayOptions& options) {
  if (image.empty()) {
    return failure({Code::PictureFormat, {}, "an empty picture cannot be shown", "a picture"});
  }
  try {
    const View view = overlay_view(image, detection, options);
    cv::Mat picture = enlarged(image, view);
    draw(picture, view, detection, options);
    if (options.with_legend) picture = with_legend(picture, detection, options.title);
    auto png = internal::encode_png_pixels({.first_row = picture.data,
                                            .row_bytes = static_cast<std::ptrdiff_t>(picture.step),
                                            .width = picture.cols,
                                            .height = picture.rows,
                                            .n_channels = picture.channels()});
    if (png) return *std::move(png);
    return failure({Code::Internal, {}, "drawing failed: " + png.error(), ""});
  } catch (const std::exception& e) {
    internal::rethrow_memory_error(e);
    return failure({Code::Internal, {}, std::string("drawing failed: ") + e.what(), ""});
  }
}

}  // namespace panelcal
