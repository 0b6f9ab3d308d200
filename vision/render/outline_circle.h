// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/render/scene.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A circle whose radius varies with the angle; see Roughness.
class RoughCircle {
 public:
  RoughCircle(double radius_mm, const Roughness& roughness);

  double radius_mm(double angle_rad) const { return evaluate(angle_rad).x(); }
  /// Radius and its derivative with the angle, mm.
  Eigen::Vector2d evaluate(double angle_rad) const;
  /// No place of the rim is farther from the centre, mm.
  double reach_mm() const { return reach_mm_; }
  /// Nowhere is the rim longer per radian, mm.
  double speed_mm() const { return speed_mm_; }
  /// 0 for a true circle.
  int highest_order() const;
  /// Area inside, mm^2.
  double area_mm2() const;

 private:
  double radius_mm_;
  int lowest_order_;
  double reach_mm_;
  double speed_mm_;
  std::vector<Eigen::Vector2d> waves_mm_;  ///< cosine and sine part from the lowest order on
};

}  // namespace panelcal::internal
