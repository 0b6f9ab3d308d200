// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "vision/fit/target.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A closed outline taken for a shape of which targets are made.
struct OutlineShape {
  Shape shape = Shape::Disc;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  double size_px = 0;
  double width_px = 0;  ///< of a cross's bars
  double angle_rad = 0;
  double quality = 0;  ///< as SeenMark::quality
};

/// The shape of an outline: a circle, from which a quarter may deviate (a track that leaves a pad),
/// a square in any position, or a cross.
///
/// In     outline_px: in order, a point a pixel or so; area_px2: what it encloses
/// Out    empty for any other shape
/// Cost   linear in the number of points
/// See    tests/vision/suggest/find_marks_test.cc
std::optional<OutlineShape> shape_of(std::span<const Eigen::Vector2d> outline_px, double area_px2);

}  // namespace panelcal::internal
