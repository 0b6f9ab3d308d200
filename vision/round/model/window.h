// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/fit/frame_patch.h"
#include "vision/picture/image.h"
#include "vision/round/model/band.h"
#include "vision/round/model/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Sums over a flat zone: all that a fit needs of it. b = (1, x, y) in window units.
struct FlatMoments {
  Eigen::Matrix3d bb = Eigen::Matrix3d::Zero();
  Eigen::Vector3d bv = Eigen::Vector3d::Zero();  ///< v above the window's reference level
  double n = 0;
};

/// Consecutive pixels of one row that lie in one zone, or near a rim.
struct RimSpan {
  int y = 0;  ///< in the window
  int x0 = 0;
  int x1 = 0;  ///< past the last
  RimZone zone = RimZone::Outside;
  bool is_band = false;
};

/// The pixels around a rim: those near it one by one, the flat ones as sums.
///
/// The window is a circle about the place where the rim was first seen; it stays where it is while
/// collect() follows the parameters.
class RimWindow {
 public:
  /// In     start: center, radius in the fit frame; outside_px: how far the window goes beyond the
  ///        rim. Where the picture ends the window ends.
  RimWindow(const Image& image,
            const FitFrame& frame,
            const RimVector& start,
            double outside_px,
            bool is_ring);

  bool empty() const { return width_ <= 0 || height_ <= 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  int x0() const { return x0_; }
  int y0() const { return y0_; }
  double full_scale() const { return image_->full_scale(); }
  /// Flat zones' sums count from here: they keep their digits.
  float reference() const { return reference_; }
  double unit_px() const { return unit_px_; }
  bool is_ring() const { return is_ring_; }

  float value(int x, int y) const { return image_->at(x0_ + x, y0_ + y); }
  const float* row(int y) const { return image_->row(y0_ + y).data() + x0_; }
  Eigen::Vector2d plane_at(int x, int y) const {
    return {(x - middle_.x()) / unit_px_, (y - middle_.y()) / unit_px_};
  }

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  /// Sorts the pixels into zones and the bands around the rims, `reach_px` to either side.
  ///
  /// Of the band only every `stride`-th row is taken. A zone of which a part is clipped is taken
  /// pixel by pixel, since its mean says nothing.
  void collect(const RimVector& p, double reach_px, int stride);

  /// The same without the sums of what is flat: flat() is that of the last collect().
  void collect_band(const RimVector& p, double reach_px, int stride);

  const RimBand& band() const { return band_; }
  RimBand& band() { return band_; }
  const std::array<FlatMoments, kRimZones>& flat() const { return flat_; }
  /// Of the last collection with stride 1: every pixel of the window once.
  const std::vector<RimSpan>& spans() const { return spans_; }

 private:
  void make_spans(const RimVector& p, double reach_px);
  void add_flat(const RimSpan& span);
  void add_row(int y, int x0, int x1);
  bool is_unclipped(const float* values, Eigen::Index n) const;
  std::array<bool, kRimZones> clipped_zones() const;

  const Image* image_;
  FramePatch patch_;
  bool is_ring_;
  double outer_ = 0;  ///< radius of the window, in the fit frame
  int x0_ = 0;
  int y0_ = 0;
  int width_ = 0;
  int height_ = 0;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();  ///< in the window, px
  double unit_px_ = 1;
  float reference_ = 0;
  bool may_be_clipped_ = true;  ///< some pixel of the window is at an end of the scale
  std::vector<RimSpan> spans_;
  RimBand band_;
  std::array<FlatMoments, kRimZones> flat_;
  Eigen::ArrayXf ramp_;  ///< 0, 1, 2 ...
};

}  // namespace panelcal::internal
