// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal::test {

/// Place at which others see a tag; OpenCV's convention: the first pixel's centre is (0, 0).
struct PeerTag {
  Eigen::Vector2d center_px;
  std::array<Eigen::Vector2d, 4> corners_px;  ///< in the order of tag_corners()
};

/// The AprilTag library's own answer: full resolution, refined edges, one wrong bit; its half pixel
/// is corrected. Of several tags of that id the first.
///
/// In     an 8-bit picture
std::optional<PeerTag> library_tag(const Image& image, std::string_view family, int id);

/// The same corners after OpenCV's cornerSubPix, and where the diagonals between them meet.
PeerTag refined_by_opencv(const Image& image, const PeerTag& start);

}  // namespace panelcal::test
