// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/tag/peers.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagStandard41h12.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace panelcal::test {
namespace {

struct Family {
  std::string_view name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

/// The small ones: tables of wrong bits of the others are large.
constexpr std::array kFamilies = {
    Family{"tag36h11", tag36h11_create, tag36h11_destroy},
    Family{"tag36h10", tag36h10_create, tag36h10_destroy},
    Family{"tag25h9", tag25h9_create, tag25h9_destroy},
    Family{"tag16h5", tag16h5_create, tag16h5_destroy},
    Family{"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    Family{"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
};

std::vector<std::uint8_t> bytes_of(const Image& image) {
  std::vector<std::uint8_t> bytes(image.pixels().size());
  std::transform(image.pixels().begin(), image.pixels().end(), bytes.begin(), [](float v) {
    return static_cast<std::uint8_t>(v);
  });
  return bytes;
}

}  // namespace

std::optional<PeerTag> library_tag(const Image& image, std::string_view family, int id) {
  const auto* f = std::find_if(
      kFamilies.begin(), kFamilies.end(), [&](const Family& e) { return e.name == family; });
  if (f == kFamilies.end()) return std::nullopt;
  const std::unique_ptr<apriltag_family_t, decltype(f->destroy)> tags(f->create(), f->destroy);
  const std::unique_ptr<apriltag_detector_t, decltype(&apriltag_detector_destroy)> detector(
      apriltag_detector_create(), apriltag_detector_destroy);
  apriltag_detector_add_family_bits(detector.get(), tags.get(), 1);
  detector->quad_decimate = 1;
  detector->refine_edges = true;
  std::vector<std::uint8_t> bytes = bytes_of(image);
  image_u8_t view{image.width(), image.height(), image.width(), bytes.data()};
  zarray_t* found = apriltag_detector_detect(detector.get(), &view);
  std::optional<PeerTag> tag;
  for (int i = 0; i < zarray_size(found) && !tag; ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found, i, &detection);
    if (detection->id != id) continue;
    const Eigen::Vector2d half(0.5, 0.5);
    tag.emplace();
    tag->center_px = Eigen::Vector2d(detection->c[0], detection->c[1]) - half;
    for (std::size_t k = 0; k < 4; ++k) {
      tag->corners_px[k] = Eigen::Vector2d(detection->p[k][0], detection->p[k][1]) - half;
    }
  }
  apriltag_detections_destroy(found);
  return tag;
}

PeerTag refined_by_opencv(const Image& image, const PeerTag& start) {
  std::vector<std::uint8_t> bytes = bytes_of(image);
  const cv::Mat picture(image.height(), image.width(), CV_8U, bytes.data());
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector2d& c : start.corners_px) {
    corners.emplace_back(static_cast<float>(c.x()), static_cast<float>(c.y()));
  }
  cv::cornerSubPix(picture,
                   corners,
                   cv::Size(5, 5),
                   cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-4));
  PeerTag tag;
  for (std::size_t k = 0; k < 4; ++k) {
    tag.corners_px[k] = {static_cast<double>(corners[k].x), static_cast<double>(corners[k].y)};
  }
  const auto line = [&](std::size_t a, std::size_t b) {
    return tag.corners_px[a].homogeneous().cross(tag.corners_px[b].homogeneous());
  };
  tag.center_px = line(0, 2).cross(line(1, 3)).hnormalized();
  return tag;
}

}  // namespace panelcal::test
