// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/render/scene_marks.h"
#include <Eigen/Geometry>

namespace panelcal::bench {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

Position<frame::Optical> place(const Camera& camera, const Eigen::Vector2d& u_px) {
  return camera.mapping(position_px<frame::Image>(u_px));
}

}  // namespace

Feature disc_at(const Camera& camera, const Eigen::Vector2d& u_px, double radius_px, double level) {
  Feature feature;
  feature.center = place(camera, u_px);
  feature.size = mm(2 * radius_px * kScaleMm);
  feature.level = level;
  return feature;
}

Feature rectangle_at(const Camera& camera,
                     const Eigen::Vector2d& u_px,
                     double length_px,
                     double width_px,
                     double angle_rad,
                     double level) {
  Feature feature;
  feature.shape = Feature::Shape::Rectangle;
  feature.center = place(camera, u_px);
  feature.size = mm(length_px * kScaleMm);
  feature.inner_size = mm(width_px * kScaleMm);
  feature.angle = rad(-angle_rad);  // Optical's y points up
  feature.level = level;
  return feature;
}

namespace {

/// Parts of an outline that are covered, by the angle that stands for a place on it.
class CoveredOutline {
 public:
  explicit CoveredOutline(double length_px)
      : radius_px_(length_px / (2 * kPi)), taken_(kSteps, false) {}

  void add(double angle_rad, double half_width_px) {
    const double half_rad = half_width_px / radius_px_;
    for (int i = 0; i < kSteps; ++i) {
      const double apart = std::remainder(i * 2 * kPi / kSteps - angle_rad, 2 * kPi);
      if (std::abs(apart) <= half_rad) taken_[static_cast<std::size_t>(i)] = true;
    }
  }
  double part() const {
    return static_cast<double>(std::count(taken_.begin(), taken_.end(), true)) / kSteps;
  }

 private:
  static constexpr int kSteps = 3600;
  double radius_px_;
  std::vector<bool> taken_;
};

/// Corners of a mark, in order; empty for round ones.
std::vector<Eigen::Vector2d> corners_of(const Mark& mark) {
  const double l = mark.radius_px;
  const double w = 0.5 * mark.bar_width_px;
  std::vector<Eigen::Vector2d> corners;
  if (mark.shape == Shape::Square || mark.shape == Shape::Diamond) {
    corners = {{l, l}, {-l, l}, {-l, -l}, {l, -l}};
  } else if (mark.shape == Shape::Cross) {
    corners = {{l, w},
               {w, w},
               {w, l},
               {-w, l},
               {-w, w},
               {-l, w},
               {-l, -w},
               {-w, -w},
               {-w, -l},
               {w, -l},
               {w, -w},
               {l, -w}};
  }
  const double turn_deg = mark.angle_deg + (mark.shape == Shape::Diamond ? 45 : 0);
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(turn_deg * kPi / 180).toRotationMatrix();
  for (Eigen::Vector2d& corner : corners) corner = turn * corner;
  return corners;
}

/// A closed line from its first corner on.
double length_of(const std::vector<Eigen::Vector2d>& corners) {
  double length = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    length += (corners[(i + 1) % corners.size()] - corners[i]).norm();
  }
  return length;
}

}  // namespace

OutlinePlace outline_place(const Mark& mark, double angle_rad) {
  const std::vector<Eigen::Vector2d> corners = corners_of(mark);
  if (corners.empty()) return {mark.radius_px * direction(angle_rad), angle_rad};
  double left = angle_rad / (2 * kPi) * length_of(corners);
  for (std::size_t i = 0;; ++i) {
    const Eigen::Vector2d& from = corners[i % corners.size()];
    const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - from;
    const double length = side.norm();
    if (left <= length || i + 1 == corners.size()) {
      return {from + left / length * side, std::atan2(-side.x(), side.y())};
    }
    left -= length;
  }
}

double outline_length(const Mark& mark) {
  const std::vector<Eigen::Vector2d> corners = corners_of(mark);
  return corners.empty() ? 2 * kPi * mark.radius_px : length_of(corners);
}

const std::vector<Condition>& conditions() {
  // In "typical" the weave's amplitude makes the coloured bound 1.65 times the white one; in "hard"
  // it puts a plain fit that is told which pixels are debris at 1.8 times the bound.
  static const std::vector<Condition> all = {
      {.name = "clean", .contrast = 140, .noise = 2, .blur_px = 1},
      {.name = "typical",
       .contrast = 100,
       .noise = 5,
       .blur_px = 1.5,
       .weave = 21.3,
       .light_gradient = 0.2},
      {.name = "hard",
       .contrast = 40,
       .noise = 12,
       .blur_px = 2.5,
       .weave = 13,
       .light_gradient = 0.2,
       .debris = 0.1,
       .n_neighbours = 3},
  };
  return all;
}

Camera make_camera(int width, int height, double blur_px, double noise, double full_scale) {
  const CameraMapping::Parameters parameters{
      .scale_mm_per_px = kScaleMm,
      .rotation_rad = 0,
      .axis_px = Eigen::Vector2d(0.5 * (width - 1), 0.5 * (height - 1)),
      .k1_per_px2 = 0};
  return {CameraMapping(parameters), width, height, blur_px, noise, full_scale};
}

Mark make_mark(Shape shape, double radius_px) {
  return {.shape = shape,
          .polarity = shape == Shape::Hole ? Polarity::Dark : Polarity::Bright,
          .radius_px = radius_px,
          .inner_radius_px = 0.5 * radius_px,
          .bar_width_px = 0.5 * radius_px};
}

Target target_of(const Mark& mark) {
  Target target;
  target.shape = mark.shape;
  target.polarity = mark.polarity;
  target.size_px = px(2 * mark.radius_px);
  if (mark.shape == Shape::Ring) target.inner_size_px = px(2 * mark.inner_radius_px);
  if (mark.shape == Shape::Cross) target.width_px = px(mark.bar_width_px);
  target.angle = deg(mark.angle_deg);
  return target;
}

std::vector<Feature> features_of(const Mark& mark,
                                 const Camera& camera,
                                 const Eigen::Vector2d& center_px,
                                 double level) {
  MarkLook look;
  look.center = place(camera, center_px);
  look.level = level;
  look.hole_offset = place(camera, center_px + mark.hole_offset_px) - look.center;
  return mark_features(target_of(mark), look, camera.mapping);
}

double background_level(const Condition& condition, Polarity polarity) {
  const double sign = polarity == Polarity::Bright ? -1 : 1;
  return 0.5 + sign * 0.5 * condition.contrast / 255;
}

double mark_level(const Condition& condition, Polarity polarity) {
  return 1 - background_level(condition, polarity);
}

Scene draw_background(const Condition& condition, Polarity polarity, Random& random) {
  Scene scene;
  scene.background = background_level(condition, polarity);
  scene.weave.amplitude = condition.weave / 255;
  scene.weave.period = mm(condition.weave_period_px * kScaleMm);
  const double x_mm = random.uniform(0, 300);
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), {x_mm, random.uniform(0, 300)});
  const double gradient_x = random.uniform(-1, 1);
  scene.light_gradient =
      condition.light_gradient * Eigen::Vector2d(gradient_x, random.uniform(-1, 1));
  return scene;
}

std::vector<Feature> draw_debris(const Camera& camera,
                                 const Eigen::Vector2d& center_px,
                                 const Mark& mark,
                                 double covered_part,
                                 Random& random) {
  std::vector<Feature> debris;
  const double length_px = outline_length(mark);
  CoveredOutline covered(length_px);
  while (covered.part() < covered_part) {
    const double left_px = (covered_part - covered.part()) * length_px;
    const double half_px = std::min(random.uniform(1.5, 5), std::max(0.5 * left_px, 0.5));
    const double angle = random.uniform(0, 2 * kPi);
    const double off_px = random.uniform(-0.5, 0.5) * half_px;
    const OutlinePlace on = outline_place(mark, angle);
    const Eigen::Vector2d at = center_px + on.offset_px + off_px * direction(on.outwards_rad);
    const double level = random.uniform();
    if (random.uniform() < 0.5) {
      debris.push_back(disc_at(camera, at, half_px, level));
      covered.add(angle, std::sqrt(half_px * half_px - off_px * off_px));
    } else {
      const double across_px = half_px * random.uniform(2, 4);
      debris.push_back(rectangle_at(camera, at, across_px, 2 * half_px, on.outwards_rad, level));
      covered.add(angle, half_px);
    }
  }
  return debris;
}

std::vector<Feature> draw_neighbours(const Camera& camera,
                                     const Eigen::Vector2d& center_px,
                                     double radius_px,
                                     double level,
                                     int n,
                                     Random& random) {
  std::vector<Feature> neighbours;
  for (int i = 0; i < n; ++i) {
    const double reach_px = radius_px * random.uniform(0.3, 0.8);
    const double angle = random.uniform(0, 2 * kPi);
    const double distance_px = radius_px + reach_px + random.uniform(6, 20);
    const Eigen::Vector2d at = center_px + distance_px * direction(angle);
    neighbours.push_back(i % 3 == 2
                             ? rectangle_at(camera, at, 2 * reach_px, 0.6 * reach_px, angle, level)
                             : disc_at(camera, at, reach_px, level));
  }
  return neighbours;
}

Sample draw_sample(
    const Condition& condition, const Mark& mark, int width, int height, Random& random) {
  Sample sample{.scene = draw_background(condition, mark.polarity, random),
                .camera = make_camera(width, height, condition.blur_px, condition.noise),
                .mark = mark,
                .center_px = {},
                .image = {}};
  const double x = 0.5 * (width - 1) + random.uniform(-20, 20);
  const double y = 0.5 * (height - 1) + random.uniform(-20, 20);
  sample.center_px = {x, y};
  // Squares and crosses reach further at their tips.
  const double reach_px =
      mark.shape == Shape::Disc || mark.shape == Shape::Hole || mark.shape == Shape::Ring
          ? mark.radius_px
          : std::numbers::sqrt2 * mark.radius_px;
  if (mark.shape == Shape::Ring) {
    const double off_x = random.uniform(-3, 3);
    sample.mark.hole_offset_px = {off_x, random.uniform(-3, 3)};
  } else if (mark.shape != Shape::Disc && mark.shape != Shape::Hole) {
    sample.mark.angle_deg += random.uniform(-3, 3);
  }
  const double level = mark_level(condition, mark.polarity);
  auto& features = sample.scene.features;
  features = draw_neighbours(
      sample.camera, sample.center_px, reach_px, level, condition.n_neighbours, random);
  sample.first_of_mark = features.size();
  for (const Feature& f : features_of(sample.mark, sample.camera, sample.center_px, level)) {
    features.push_back(f);
  }
  sample.first_debris = features.size();
  for (const Feature& f :
       draw_debris(sample.camera, sample.center_px, sample.mark, condition.debris, random)) {
    features.push_back(f);
  }
  sample.image = render(sample.scene, sample.camera, random);
  return sample;
}

}  // namespace panelcal::bench
