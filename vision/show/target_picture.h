// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "vision/fit/detection.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal {

/// The piece of a picture around a detection, and what was found in it, px of the whole picture.
struct TargetPicture {
  /// A place that was looked at beside the best one.
  struct Other {
    Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
    double size_px = 0;
    bool counts = false;
    std::string reason;  ///< of one that does not count
  };

  std::string jpeg;    ///< grey; the piece, scaled down to at most kMaxSide_px
  double left_px = 0;  ///< of the piece: the edge of its first pixel
  double top_px = 0;
  double width_px = 0;
  double height_px = 0;
  /// Of the best candidate; without one the other fields of it say nothing.
  std::optional<Eigen::Vector2d> center_px;
  Eigen::Matrix2d cov_px2 = Eigen::Matrix2d::Zero();
  double contrast = 0;  ///< of full scale
  double blur_px = 0;
  std::vector<std::vector<Eigen::Vector2d>> outlines_px;
  std::vector<Other> others;

  static constexpr int kMaxSide_px = 360;
};

/// Cuts out what matters, as encode_overlay() does, and keeps what was found as numbers: who shows
/// the picture draws it in.
///
/// Fails  picture-format (an empty picture)
/// Cost   about 1 ms
/// See    tests/vision/show/target_picture_test.cc
Expected<TargetPicture> target_picture(const Image& image, const Detection& detection);

}  // namespace panelcal
