// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The plane in which discs are round, in units of about one pixel.
///
///   X = (K(u) - K(u0)) / scale with a camera mapping, X = u - u0 without one
///
/// u0 is a pixel near the target, so that numbers stay small.
class FitFrame {
 public:
  FitFrame(const CameraMapping* mapping, const Eigen::Vector2d& origin_px)
      : mapping_(mapping), origin_px_(origin_px) {
    if (!mapping_) return;
    scale_mm_ = mapping_->parameters().scale_mm_per_px;
    origin_mm_ = (*mapping_)(position_px<frame::Image>(origin_px)).in_mm();
  }

  const CameraMapping* mapping() const { return mapping_; }
  /// mm per unit; 1 (px) without a mapping.
  double unit() const { return mapping_ ? scale_mm_ : 1.0; }

  Eigen::Vector2d from_image(const Eigen::Vector2d& u_px) const {
    if (!mapping_) return u_px - origin_px_;
    return ((*mapping_)(position_px<frame::Image>(u_px)).in_mm() - origin_mm_) / scale_mm_;
  }
  /// dX/du.
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& u_px) const {
    if (!mapping_) return Eigen::Matrix2d::Identity();
    return mapping_->jacobian(position_px<frame::Image>(u_px)) / scale_mm_;
  }
  /// Empty where the lens model folds over.
  std::optional<Eigen::Vector2d> to_image(const Eigen::Vector2d& x) const {
    if (!mapping_) return origin_px_ + x;
    const auto u = mapping_->image_of(to_optical(x));
    if (!u) return std::nullopt;
    return u->in_px();
  }
  /// Precondition: mapping().
  Position<frame::Optical> to_optical(const Eigen::Vector2d& x) const {
    return position_mm<frame::Optical>(Eigen::Vector2d(origin_mm_ + scale_mm_ * x));
  }

 private:
  const CameraMapping* mapping_;
  Eigen::Vector2d origin_px_;
  double scale_mm_ = 1;
  Eigen::Vector2d origin_mm_ = Eigen::Vector2d::Zero();
};

/// Those of an outline's places that the lens model can draw, px.
inline std::vector<Eigen::Vector2d> in_picture(const FitFrame& fit_frame,
                                               const std::vector<Eigen::Vector2d>& outline) {
  std::vector<Eigen::Vector2d> outline_px;
  for (const Eigen::Vector2d& at : outline) {
    if (const auto u = fit_frame.to_image(at)) outline_px.push_back(*u);
  }
  return outline_px;
}

/// A target's length in units of its fit frame: given in mm with a mapping, in px without one.
inline std::optional<double> frame_length(const std::optional<Length>& length,
                                          const std::optional<PixelLength>& length_px,
                                          const CameraMapping* mapping) {
  if (length && mapping) return length->in_mm() / mapping->parameters().scale_mm_per_px;
  // The frame's unit is the size of a pixel where the mapping has its nominal scale.
  if (length_px) return length_px->in_px();
  return std::nullopt;
}

}  // namespace panelcal::internal
