// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal::bench {

/// Under which circumstances pictures are taken; grey levels of 255.
struct Condition {
  std::string name;
  double contrast = 140;
  double noise = 2;
  double blur_px = 1;  ///< of the lens; the pixel's square comes on top
  double weave = 0;    ///< amplitude
  double weave_period_px = 50;
  double light_gradient = 0;  ///< largest relative change across the picture, either way
  double debris = 0;          ///< part of the rim that is covered
  int n_neighbours = 0;
};

/// The three conditions of docs and README: clean, typical, hard.
const std::vector<Condition>& conditions();

/// The mark that is looked for, in px.
struct Mark {
  Shape shape = Shape::Disc;
  Polarity polarity = Polarity::Bright;
  double radius_px = 40;        ///< half the size
  double angle_deg = 0;         ///< of squares and crosses, against the picture's x
  double inner_radius_px = 20;  ///< of rings
  double bar_width_px = 20;     ///< of crosses
  Eigen::Vector2d hole_offset_px = Eigen::Vector2d::Zero();  ///< of rings
};

/// Half as wide inside, bars half a radius wide; holes are dark.
Mark make_mark(Shape shape, double radius_px);

/// A picture with its truth.
struct Sample {
  Scene scene;
  Camera camera;
  Mark mark;
  Eigen::Vector2d center_px;
  /// Features from here on are painted over the mark.
  std::size_t first_debris = 0;
  /// Features before this one lie beside the mark.
  std::size_t first_of_mark = 0;
  Image image;
};

/// Millimetres of a pixel in every picture here; lengths of scenes are in mm.
inline constexpr double kScaleMm = 0.01;

Camera make_camera(int width, int height, double blur_px, double noise, double full_scale = 255);
/// Things at a place of the picture; lengths in px, angles from the picture's x towards its y.
Feature disc_at(const Camera& camera, const Eigen::Vector2d& u_px, double radius_px, double level);
Feature rectangle_at(const Camera& camera,
                     const Eigen::Vector2d& u_px,
                     double length_px,
                     double width_px,
                     double angle_rad,
                     double level);

/// Target that the locator is told.
Target target_of(const Mark& mark);
/// The mark at a place.
std::vector<Feature> features_of(const Mark& mark,
                                 const Camera& camera,
                                 const Eigen::Vector2d& center_px,
                                 double level);

/// Background and mark levels, 0 to 1, symmetric about the middle of the scale.
double background_level(const Condition& condition, Polarity polarity);
double mark_level(const Condition& condition, Polarity polarity);

/// A scene without marks: background, weave and light as the condition says, at random.
Scene draw_background(const Condition& condition, Polarity polarity, Random& random);

/// Draws place, light, weave, neighbours and debris, and renders. Squares and crosses are turned by
/// up to 3 degrees against the mark asked for, and rings' holes are up to 3 px off-centre: neither
/// is known to anybody.
Sample draw_sample(
    const Condition& condition, const Mark& mark, int width, int height, Random& random);

/// A place on a mark's outer outline.
struct OutlinePlace {
  Eigen::Vector2d offset_px;  ///< from the mark's centre
  double outwards_rad;        ///< from the picture's x towards its y
};

/// In     angle_rad: 0 to 2 pi runs once around the outline, evenly along it
OutlinePlace outline_place(const Mark& mark, double angle_rad);
double outline_length(const Mark& mark);

/// Opaque blobs painted on an outline, as draw_sample does until the part is covered.
std::vector<Feature> draw_debris(const Camera& camera,
                                 const Eigen::Vector2d& center_px,
                                 const Mark& mark,
                                 double covered_part,
                                 Random& random);
/// Pads and tracks beside a mark, none of its size, 6 to 20 px from its rim.
std::vector<Feature> draw_neighbours(const Camera& camera,
                                     const Eigen::Vector2d& center_px,
                                     double radius_px,
                                     double level,
                                     int n,
                                     Random& random);

}  // namespace panelcal::bench
