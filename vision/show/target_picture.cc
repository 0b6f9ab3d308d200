// SPDX-License-Identifier: Apache-2.0
#include "vision/show/target_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>

#include "vision/picture/cv_bridge.h"
#include "vision/picture/formats/jpeg_encoder.h"
#include "vision/picture/memory_error.h"
#include "vision/show/shown_box.h"
#include <opencv2/imgproc.hpp>

namespace panelcal {
namespace {

/// Fine enough for the edge of a target; half the bytes of 95.
constexpr int kJpegQuality = 82;
/// Nodes of an outline that a drawing can tell apart.
constexpr std::size_t kMaxNodes = 120;

/// The piece in 8 bit, grey levels as they are: a faint target must not look clear.
std::string piece_as_jpeg(const Image& image, const cv::Rect& box) {
  cv::Mat grey;
  internal::mat_of(image)(box).convertTo(grey, CV_8U, Image::kFullScale8 / image.full_scale());
  const int side = std::max(box.width, box.height);
  if (side > TargetPicture::kMaxSide_px) {
    const double scale = static_cast<double>(TargetPicture::kMaxSide_px) / side;
    cv::Mat small;
    cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
    grey = small;
  }
  return internal::encode_grey_jpeg({grey.ptr(), grey.total()}, grey.cols, grey.rows, kJpegQuality);
}

std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& outline_px) {
  const std::size_t stride = outline_px.size() / kMaxNodes + 1;
  std::vector<Eigen::Vector2d> out;
  for (std::size_t i = 0; i < outline_px.size(); i += stride) {
    if (outline_px[i].allFinite()) out.push_back(outline_px[i]);
  }
  return out;
}

void take_best(const Image& image, const TargetFit& best, TargetPicture& out) {
  out.center_px = best.center.position.in_px();
  out.cov_px2 = best.center.cov;
  out.contrast = best.contrast / image.full_scale();
  out.blur_px = best.blur_px;
  for (const auto& outline : best.outlines_px) out.outlines_px.push_back(thinned(outline));
}

}  // namespace

Expected<TargetPicture> target_picture(const Image& image, const Detection& detection) {
  if (image.empty()) {
    return failure({Code::PictureFormat, {}, "an empty picture cannot be shown", "a picture"});
  }
  try {
    const cv::Rect box = internal::shown_box(image, detection);
    TargetPicture out;
    out.jpeg = piece_as_jpeg(image, box);
    out.left_px = box.x - 0.5;
    out.top_px = box.y - 0.5;
    out.width_px = box.width;
    out.height_px = box.height;
    if (detection.best) take_best(image, *detection.best, out);
    for (const Candidate& other : detection.candidates) {
      const Eigen::Vector2d& center_px = other.center.in_px();
      const bool is_best = out.center_px && (center_px - *out.center_px).norm() < 1e-6;
      if (is_best || !center_px.allFinite()) continue;
      out.others.push_back({center_px, other.size.in_px(), other.counts, other.reason});
    }
    return out;
  } catch (const std::exception& e) {
    internal::rethrow_memory_error(e);
    return failure({Code::Internal, {}, std::string("drawing failed: ") + e.what(), ""});
  }
}

}  // namespace panelcal
