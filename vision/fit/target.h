// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal {

/// The shapes, one for each row.
enum class Shape {
#define PANELCAL_SHAPE(shape, word, size, detector, max_fitted) shape,
#include "vision/fit/shapes.def"
};
enum class Polarity { Bright, Dark };  ///< the target against its surroundings

std::string_view name(Shape shape);
std::string_view name(Polarity polarity);
/// Meaning of a shape's size, for messages: "the outer diameter".
std::string_view size_words(Shape shape);
std::optional<Shape> shape_from_name(std::string_view name);
std::optional<Polarity> polarity_from_name(std::string_view name);

/// A picture of the mark to look for.
struct TemplatePicture {
  std::string file;  ///< for messages
  Image image;
  /// The place in `image` that is the target's; its middle if not stated otherwise, px.
  Eigen::Vector2d reference_px = Eigen::Vector2d::Zero();
};

/// The description of a target: a vision tool.
///
/// A size is a disc's, hole's, ring's or dot's outer diameter, a square's or diamond's side, a
/// tag's side (of the square that its corners make), the length of a cross's bars from tip to tip,
/// a slot's width between its long edges, a template's width. It is given in mm if pictures come
/// with a camera mapping, or in pixels if they do not; never both. The same holds for the other
/// lengths. "The frame" below is Optical if there is a mapping, else the picture (y down); angles
/// count from its x towards its y.
struct Target {
  int number = 0;  ///< of the vision tool
  Shape shape = Shape::Disc;
  std::optional<Length> size;
  std::optional<PixelLength> size_px;
  /// A ring's inner diameter, which may be left out: then any hole is accepted.
  std::optional<Length> inner_size;
  std::optional<PixelLength> inner_size_px;
  /// A cross's bars from edge to edge.
  std::optional<Length> width;
  std::optional<PixelLength> width_px;
  /// Templates, tags: Bright looks for what picture or family show, Dark for their negative.
  Polarity polarity = Polarity::Bright;
  /// Largest accepted deviation of the seen size, relative. Wide enough for etching and drilling
  /// tolerances, narrow enough to tell neighbouring pad sizes apart.
  double size_tolerance = 0.04;
  /// Direction of squares, diamonds, crosses, slots (their long axis), dots and templates in the
  /// frame, and by how much they may be turned against it. Tags may lie in any way.
  Angle angle;
  Angle angle_tolerance = deg(5);
  /// Dots' middles from the target's place, in the frame; mm or px as the size is.
  std::vector<Eigen::Vector2d> dots;
  std::shared_ptr<const TemplatePicture> picture;  ///< templates only
  std::string tag_family = "tag36h11";
  std::optional<int> tag_id;  ///< absent: any tag of the family

  /// Fails  target-invalid: names the field, its value and the bound it breaks
  Expected<void> validate() const;
};

}  // namespace panelcal
