// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/frame.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A fit frame near one pixel, as fast polynomials:
///
///   X(u) = sum_ij C_ij dx^i dy^j, i, j <= 3,   (dx, dy) = (u - u0) / unit
///
/// Camera mappings are cubic, so that interpolation at four by four places gives them exactly.
class FramePatch {
 public:
  /// In     center_px: the middle of the patch; half_px: half its side, above 0
  FramePatch(const FitFrame& frame, const Eigen::Vector2d& center_px, double half_px);

  /// True if a pixel is a unit and the frame is not turned: without a camera mapping.
  bool is_plain() const { return is_plain_; }
  const Eigen::Vector2d& center_px() const { return center_px_; }
  /// X and dX/du at the middle.
  const Eigen::Vector2d& center_place() const { return c_[0][0]; }
  const Eigen::Matrix2d& center_jacobian() const { return center_jacobian_; }

  /// The frame along one row of pixels.
  class Row {
   public:
    struct At {
      Eigen::Vector2d place;
      Eigen::Matrix2d jacobian;  ///< dX/du
    };
    At at(int x) const {
      const double d = (x - x0_) * per_px_;
      const Eigen::Vector2d place = c_[0] + d * (c_[1] + d * (c_[2] + d * c_[3]));
      At at{place, {}};
      at.jacobian.col(0) = per_px_ * (c_[1] + d * (2 * c_[2] + 3 * d * c_[3]));
      at.jacobian.col(1) = per_px_ * (e_[0] + d * (e_[1] + d * (e_[2] + d * e_[3])));
      return at;
    }

   private:
    friend class FramePatch;
    double x0_ = 0;
    double per_px_ = 1;
    Eigen::Vector2d c_[4];  ///< by powers of dx
    Eigen::Vector2d e_[4];  ///< the same, of the derivative by dy
  };
  Row row(int y) const;

  /// Deviation of the frame from linear within `distance_px` of the middle, in its units.
  double bend(double distance_px) const;

 private:
  Eigen::Vector2d center_px_;
  bool is_plain_;
  double unit_px_ = 1;
  Eigen::Vector2d c_[4][4];  ///< [power of dx][power of dy]
  Eigen::Matrix2d center_jacobian_;
};

}  // namespace panelcal::internal
