// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_marks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "vision/render/outline.h"
#include "vision/tag/family.h"

namespace panelcal {
namespace {

/// The hole of a ring whose vision tool accepts any.
constexpr double kInnerShare = 0.5;

/// The frame that a target is described in, Optical or the picture (see Target), on the board.
class TargetFrame {
 public:
  TargetFrame(const Target& target, const CameraMapping& mapping) {
    if (target.size) return;
    unit_mm_ = mapping.parameters().scale_mm_per_px;
    rotation_ = rad(mapping.parameters().rotation_rad);
    handedness_ = -1;  // y is down in a picture
  }

  Length length(const std::optional<Length>& in_mm, const std::optional<PixelLength>& in_px) const {
    return in_mm ? *in_mm : mm(in_px->in_px() * unit_mm_);
  }
  Angle angle(Angle in_frame) const { return rotation_ + handedness_ * in_frame; }
  /// Of a displacement in the frame that is turned by `turn` first.
  Displacement<frame::Optical> displacement(const Eigen::Vector2d& v, Angle turn) const {
    const double a = angle(turn).in_rad();
    const Eigen::Vector2d x(std::cos(a), std::sin(a));
    const Eigen::Vector2d y(-x.y(), x.x());
    const Eigen::Vector2d v_mm = unit_mm_ * (v.x() * x + handedness_ * v.y() * y);
    return displacement_mm<frame::Optical>(v_mm);
  }

 private:
  double unit_mm_ = 1;
  Angle rotation_;
  double handedness_ = 1;
};

std::shared_ptr<const CellGrid> cross_cells(Length length, Length width, double level) {
  CellGrid grid;
  grid.x = {-0.5 * length, -0.5 * width, 0.5 * width, 0.5 * length};
  grid.y = grid.x;
  grid.levels.assign(9, level);
  for (const std::size_t corner : {0u, 2u, 6u, 8u}) grid.levels[corner].reset();
  return std::make_shared<const CellGrid>(std::move(grid));
}

/// A tag's first row is on top; a grid's first row is at the bottom.
std::shared_ptr<const CellGrid> tag_cells(const TagPattern& pattern,
                                          Length size,
                                          double white,
                                          double black) {
  CellGrid grid;
  for (const double line : pattern.lines) grid.x.push_back(line * size);
  for (auto line = pattern.lines.rbegin(); line != pattern.lines.rend(); ++line) {
    grid.y.push_back(-*line * size);
  }
  for (int row = pattern.n_cells - 1; row >= 0; --row) {
    for (int column = 0; column < pattern.n_cells; ++column) {
      const TagCell cell = pattern.at(column, row);
      grid.levels.push_back(cell == TagCell::Any
                                ? std::nullopt
                                : std::optional(cell == TagCell::White ? white : black));
    }
  }
  return std::make_shared<const CellGrid>(std::move(grid));
}

std::vector<Feature> dots_of(const Target& target,
                             const MarkLook& look,
                             const TargetFrame& frame,
                             const Feature& dot) {
  std::vector<Feature> features;
  for (const Eigen::Vector2d& at : target.dots) {
    Feature feature = dot;
    feature.center = look.center + frame.displacement(at, target.angle + look.turn);
    features.push_back(feature);
  }
  return features;
}

/// The template's picture or its negative.
std::shared_ptr<const TemplatePicture> shown_picture(const Target& target) {
  if (target.polarity == Polarity::Bright || !target.picture) return target.picture;
  TemplatePicture negative = *target.picture;
  const auto white = static_cast<float>(negative.image.full_scale());
  for (float& level : negative.image.pixels()) level = white - level;
  return std::make_shared<const TemplatePicture>(std::move(negative));
}

void add_ring_hole(const Target& target,
                   const MarkLook& look,
                   const TargetFrame& frame,
                   Feature& feature) {
  feature.shape = Feature::Shape::Ring;
  feature.inner_size = target.inner_size || target.inner_size_px
                           ? frame.length(target.inner_size, target.inner_size_px)
                           : kInnerShare * feature.size;
  feature.hole_offset = look.hole_offset;
}

}  // namespace

std::vector<Feature> mark_features(const Target& target,
                                   const MarkLook& look,
                                   const CameraMapping& mapping) {
  const TargetFrame frame(target, mapping);
  Feature feature;
  feature.center = look.center;
  feature.size = frame.length(target.size, target.size_px);
  feature.angle = frame.angle(target.angle + look.turn);
  feature.level = look.level;
  switch (target.shape) {
    default:
      break;  // a disc of its size
    case Shape::Hole:
      feature.roughness = look.burrs;
      break;
    case Shape::Ring:
      add_ring_hole(target, look, frame, feature);
      break;
    case Shape::Diamond:
      feature.angle = feature.angle + deg(45);
      [[fallthrough]];
    case Shape::Square:
      feature.shape = Feature::Shape::Rectangle;
      feature.inner_size = feature.size;
      break;
    case Shape::Cross:
      feature.shape = Feature::Shape::Cells;
      feature.cells =
          cross_cells(feature.size, frame.length(target.width, target.width_px), look.level);
      break;
    case Shape::Slot:
      feature.shape = Feature::Shape::Stadium;
      feature.inner_size = feature.size;
      feature.size = std::max(feature.size, look.slot_length);
      break;
    case Shape::Dots:
      return dots_of(target, look, frame, feature);
    case Shape::Template:
      feature.shape = Feature::Shape::Picture;
      feature.picture = shown_picture(target);
      break;
    case Shape::AprilTag: {
      const auto pattern = tag_pattern(target.tag_family, target.tag_id.value_or(0));
      if (!pattern) return {};
      feature.shape = Feature::Shape::Cells;
      feature.cells = tag_cells(*pattern, feature.size, look.level, look.ground);
      break;
    }
  }
  return {feature};
}

Length reach_of(const std::vector<Feature>& features, const Position<frame::Optical>& from) {
  double reach_mm = 0;
  for (const Feature& feature : features) {
    const internal::Outline outline = internal::outline_of(feature);
    for (const internal::Side& side : outline.sides) {
      reach_mm =
          std::max({reach_mm, (side.from - from.in_mm()).norm(), (side.to - from.in_mm()).norm()});
    }
    for (const internal::Arc& arc : outline.arcs) {
      reach_mm = std::max(reach_mm, (arc.center - from.in_mm()).norm() + arc.rim.reach_mm());
    }
  }
  return mm(reach_mm);
}

}  // namespace panelcal
