// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/quads.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "vision/picture/cv_bridge.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <apriltag/apriltag.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::internal {
namespace {

/// The library counts pixels with 15 bits and looks at tiles of 4 x 4.
constexpr int kMaxQuadSide = 32767;
constexpr int kMinQuadSide = 12;
constexpr double kQuadOfContrast = 0.5;

/// A smaller, smoother, full-contrast picture of the box.
struct ReducedPicture {
  cv::Mat pixels;  ///< 8 bit
  Eigen::Vector2d factor;
  PixelBox box;
  double gain = 0;  ///< of its grey levels

  /// From the library's coordinates, in which the first pixel's centre is at (0.5, 0.5).
  Eigen::Vector2d to_image(const double p[2]) const {
    return {p[0] * factor.x() - 0.5 + box.x0, p[1] * factor.y() - 0.5 + box.y0};
  }
};

ReducedPicture reduce(const Image& image,
                      const PixelBox& box,
                      double cell_px,
                      const TagView& view,
                      bool is_inverted) {
  const cv::Mat part = pixels_of(image)(cv::Rect(box.x0, box.y0, box.width, box.height));
  ReducedPicture reduced;
  reduced.box = box;
  const double factor = std::max(1.0, cell_px / view.cell_px);
  const auto side = [&](int n) { return std::max(1, static_cast<int>(std::lround(n / factor))); };
  cv::Mat smooth;
  if (factor > 1.01) {
    cv::resize(part, smooth, cv::Size(side(box.width), side(box.height)), 0, 0, cv::INTER_AREA);
  } else {
    smooth = part.clone();
  }
  reduced.factor = {static_cast<double>(part.cols) / smooth.cols,
                    static_cast<double>(part.rows) / smooth.rows};
  if (view.blur_px > 0) cv::GaussianBlur(smooth, smooth, cv::Size(), view.blur_px);
  // The library wants at least a few grey levels of contrast wherever a tag may be.
  double low = 0;
  double high = 0;
  cv::minMaxLoc(smooth, &low, &high);
  const double gain = high > low ? Image::kFullScale8 / (high - low) : 0;
  reduced.gain = gain;
  if (is_inverted) {
    smooth.convertTo(reduced.pixels, CV_8U, -gain, gain * high);
  } else {
    smooth.convertTo(reduced.pixels, CV_8U, gain, -gain * low);
  }
  return reduced;
}

/// The library's detector with a family in which everything is a code: every quad is reported.
///
/// Reading is left to tag_reader.h: the library's tables of codes with a wrong bit take 0.1 s and
/// 150 MB for the large families.
class QuadFinder {
 public:
  QuadFinder(const TagFamily& family, int min_contrast) {
    constexpr std::size_t kMaxBits = 12;
    const int first = (family.n_cells - family.n_on_side) / 2;
    // Quads that overlap and have equal codes count as one for the library, and the smaller ones
    // within a tag must not win over it: as many bits as are cheap, from all over the tag.
    const std::size_t n_bits = std::min(kMaxBits, family.bits.size());
    for (std::size_t i = 0; i < n_bits; ++i) {
      const TagFamily::Bit& bit = family.bits[i * family.bits.size() / n_bits];
      bit_x_.push_back(static_cast<std::uint32_t>(bit.column - first));
      bit_y_.push_back(static_cast<std::uint32_t>(bit.row - first));
    }
    for (std::uint64_t code = 0; code < std::uint64_t{1} << n_bits; ++code) codes_.push_back(code);
    family_.ncodes = static_cast<std::uint32_t>(codes_.size());
    family_.codes = codes_.data();
    family_.width_at_border = family.n_on_side;
    family_.total_width = family.n_cells;
    family_.reversed_border = family.is_reversed;
    family_.nbits = static_cast<std::uint32_t>(n_bits);
    family_.bit_x = bit_x_.data();
    family_.bit_y = bit_y_.data();
    family_.h = 1;
    detector_ = apriltag_detector_create();
    apriltag_detector_add_family_bits(detector_, &family_, 0);
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;
    detector_->quad_sigma = 0;  // would blur the picture in place
    detector_->refine_edges = true;
    detector_->qtp.min_white_black_diff = min_contrast;
  }
  ~QuadFinder() { apriltag_detector_destroy(detector_); }
  QuadFinder(const QuadFinder&) = delete;
  QuadFinder& operator=(const QuadFinder&) = delete;

  std::vector<TagQuad> find(ReducedPicture& picture) {
    image_u8_t view{picture.pixels.cols,
                    picture.pixels.rows,
                    static_cast<std::int32_t>(picture.pixels.step),
                    picture.pixels.data};
    zarray_t* detections = apriltag_detector_detect(detector_, &view);
    std::vector<TagQuad> quads;
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(detections, i, &detection);
      TagQuad quad;
      for (std::size_t k = 0; k < 4; ++k) {
        quad.corners_px[k] = picture.to_image(detection->p[k]);
      }
      quads.push_back(quad);
    }
    apriltag_detections_destroy(detections);
    return quads;
  }

 private:
  std::vector<std::uint64_t> codes_;
  std::vector<std::uint32_t> bit_x_;
  std::vector<std::uint32_t> bit_y_;
  apriltag_family_t family_{};
  apriltag_detector_t* detector_ = nullptr;
};

bool is_usable(const TagQuad& quad) {
  return std::all_of(quad.corners_px.begin(),
                     quad.corners_px.end(),
                     [](const auto& c) { return c.allFinite(); }) &&
         quad.image_from_tag().allFinite();
}

}  // namespace

Eigen::Matrix3d TagQuad::image_from_tag() const {
  // The columns of a projective basis (Hartley and Zisserman 2004, 2.3): three corners, weighted so
  // that their sum is the fourth.
  const auto basis = [](const std::array<Eigen::Vector2d, 4>& p) {
    Eigen::Matrix3d m;
    for (int i = 0; i < 3; ++i) m.col(i) = p[static_cast<std::size_t>(i)].homogeneous();
    const Eigen::Vector3d weights = m.partialPivLu().solve(p[3].homogeneous());
    return Eigen::Matrix3d(m * weights.asDiagonal());
  };
  const Eigen::Matrix3d h = basis(corners_px) * basis(tag_corners()).inverse();
  return h / h(2, 2);
}

TagQuad TagQuad::turned(int quarters) const {
  TagQuad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    quad.corners_px[i] = corners_px[(i + static_cast<std::size_t>(quarters)) % 4];
  }
  return quad;
}

double TagQuad::mean_side_px() const {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += (corners_px[(i + 1) % 4] - corners_px[i]).norm();
  return sum / 4;
}

std::vector<TagQuad> find_tag_quads(const Image& image,
                                    const PixelBox& box,
                                    const TagFamily& family,
                                    double cell_px,
                                    const TagView& view,
                                    double min_contrast,
                                    bool is_inverted) {
  if (box.width < 1 || box.height < 1) return {};
  ReducedPicture picture = reduce(image, box, cell_px, view, is_inverted);
  const auto is_good = [](int n) { return n >= kMinQuadSide && n <= kMaxQuadSide; };
  if (!is_good(picture.pixels.cols) || !is_good(picture.pixels.rows)) return {};
  // Between the blurred cells of a tag the contrast is less, but noise must not be looked at.
  const int least = std::max(5, static_cast<int>(kQuadOfContrast * min_contrast * picture.gain));
  std::vector<TagQuad> quads = QuadFinder(family, least).find(picture);
  std::erase_if(quads, [](const TagQuad& quad) { return !is_usable(quad); });
  return quads;
}

}  // namespace panelcal::internal
