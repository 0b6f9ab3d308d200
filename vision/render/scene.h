// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "vision/fit/target.h"
#include "vision/texture/weave_parameters.h"
#include <Eigen/Core>

namespace panelcal {

/// A grid of rectangular cells of one brightness each: squares, crosses, tags, checkerboards.
struct CellGrid {
  std::vector<Length> x;  ///< lines, ascending, from the feature's centre along its angle
  std::vector<Length> y;  ///< the same a quarter turn counter-clockwise of x: upwards, if angle = 0
  /// Brightness of the cell from x[i] to x[i + 1] and from y[j] to y[j + 1] at
  /// [j * (x.size() - 1) + i], 0 to 1 of full scale; an empty one lets through what lies below.
  std::vector<std::optional<double>> levels;
};

/// Deviation of a rim from a circle: burrs of a drilled hole, the outline of a crumb of dirt.
///
/// The radius varies with the angle by a random sum of sines whose amplitude falls as 1 / order.
/// Order 1 would be a shift of the whole, and is not among them.
struct Roughness {
  Length rms;            ///< of the radius; reduced where a rim would come near the centre
  int lowest_order = 2;  ///< at least 2
  int highest_order = 24;
  std::uint64_t seed = 1;
};

/// The features of a panel: marks, and things that are not marks.
struct Feature {
  enum class Shape {
    Disc,
    Ring,
    Rectangle,
    Stadium,  ///< a rectangle with half discs at its ends: a milled slot
    Cells,
    Picture,
  };

  Shape shape = Shape::Disc;
  Position<frame::Optical> center;
  Length size;        ///< outer diameter; a rectangle's or stadium's length; a picture's width
  Length inner_size;  ///< a ring's hole; a rectangle's or stadium's width
  Angle angle;        ///< of a rectangle's length, a grid's or a picture's x against x
  double level = 0;   ///< brightness, 0 to 1 of full scale
  Displacement<frame::Optical> hole_offset = {};  ///< middle of a ring's hole from `center`
  Roughness roughness = {};                       ///< of a disc's rim and a ring's two
  std::shared_ptr<const CellGrid> cells = {};
  /// Its reference place is at `center`. It is as bright as it is, and as sharp.
  std::shared_ptr<const TemplatePicture> picture = {};
};

/// A piece of panel under the camera. Features are painted in order: later ones cover earlier ones.
struct Scene {
  std::vector<Feature> features;
  double background = 0.3;  ///< brightness, 0 to 1 of full scale
  Weave weave;              ///< seen on the background only
  /// Relative change of the light from the left to the right edge of the picture, and from top to
  /// bottom. It multiplies everything, as light does.
  Eigen::Vector2d light_gradient = Eigen::Vector2d::Zero();
  double vignetting = 0;  ///< relative loss of light in the corners
  double lamp = 1;        ///< times all brightness
};

}  // namespace panelcal
