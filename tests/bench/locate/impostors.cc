// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/impostors.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace panelcal::bench {
namespace {

constexpr double kPi = std::numbers::pi;

using Features = std::vector<Feature>;

Eigen::Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

Features scaled_mark(const Stage& s, double factor) {
  Mark mark = s.mark;
  mark.radius_px *= factor;
  mark.inner_radius_px *= factor;
  mark.bar_width_px *= factor;
  return features_of(mark, s.camera, s.center_px, s.level);
}

Features shape_instead(const Stage& s, Shape shape, double radius_px, double angle_deg = 0) {
  Mark mark = make_mark(shape, radius_px);
  mark.angle_deg = angle_deg;
  return features_of(mark, s.camera, s.center_px, s.level);
}

/// The mark itself, half of it hidden under something of the board's brightness: 40 to 60 % of a
/// round rim are left.
Features half_mark(const Stage& s, Random& random) {
  Features features = features_of(s.mark, s.camera, s.center_px, s.level);
  const double angle = random.uniform(0, 2 * kPi);
  const double side_px = 4 * s.mark.radius_px;
  const double edge_px = random.uniform(-0.3, 0.3) * s.mark.radius_px;
  features.push_back(rectangle_at(s.camera,
                                  s.center_px + (edge_px + side_px / 2) * direction(angle),
                                  side_px,
                                  side_px,
                                  angle,
                                  s.background));
  return features;
}

/// The mark cut off by the picture's border, its centre at most 0.2 radii inside.
Features mark_over_border(const Stage& s, Random& random) {
  Stage moved{s.camera, s.mark, s.center_px, s.level, s.background};
  const double inside_px = random.uniform(-0.5, 0.2) * s.mark.radius_px;
  if (random.uniform() < 0.5) {
    moved.center_px.x() = random.uniform() < 0.5 ? inside_px : s.camera.width - 1 - inside_px;
  } else {
    moved.center_px.y() = random.uniform() < 0.5 ? inside_px : s.camera.height - 1 - inside_px;
  }
  return scaled_mark(moved, 1);
}

Features oblong(const Stage& s, Random& random) {
  const double angle = random.uniform(0, kPi);
  const double length_px = random.uniform(0.3, 2) * s.mark.radius_px;
  const Eigen::Vector2d half = 0.5 * length_px * direction(angle);
  const double r = s.mark.radius_px;
  return {rectangle_at(s.camera, s.center_px, length_px, 2 * r, angle, s.level),
          disc_at(s.camera, s.center_px - half, r, s.level),
          disc_at(s.camera, s.center_px + half, r, s.level)};
}

/// A regular hexagon is the union of three rectangles.
Features hexagon(const Stage& s, Random& random) {
  const double angle = random.uniform(0, kPi);
  const double corner_px = s.mark.radius_px * random.uniform(1.0, 1.15);
  Features features;
  for (int i = 0; i < 3; ++i) {
    features.push_back(rectangle_at(s.camera,
                                    s.center_px,
                                    corner_px,
                                    std::numbers::sqrt3 * corner_px,
                                    angle + i * kPi / 3,
                                    s.level));
  }
  return features;
}

Features tracks(const Stage& s, Random& random) {
  const double angle = random.uniform(0, kPi);
  const double width_px = random.uniform(0.2, 2) * s.mark.radius_px;
  const double pitch_px = width_px * random.uniform(1.5, 3);
  Features features;
  for (int i = -3; i <= 3; ++i) {
    features.push_back(rectangle_at(s.camera,
                                    s.center_px + i * pitch_px * direction(angle + kPi / 2),
                                    3000,
                                    width_px,
                                    angle,
                                    s.level));
  }
  return features;
}

Features board_edge(const Stage& s, Random& random) {
  const double angle = random.uniform(0, 2 * kPi);
  return {
      rectangle_at(s.camera, s.center_px + 1000 * direction(angle), 2000, 3000, angle, s.level)};
}

Features clutter(const Stage& s, Random& random) {
  Features features;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d at(random.uniform(0, s.camera.width), random.uniform(0, s.camera.height));
    const double size_px = s.mark.radius_px * random.uniform(0.1, 0.8);
    const double level = random.uniform();
    features.push_back(
        random.uniform() < 0.5
            ? disc_at(s.camera, at, 0.5 * size_px, level)
            : rectangle_at(s.camera, at, size_px, 0.5 * size_px, random.uniform(0, kPi), level));
  }
  return features;
}

Features debris_circle(const Stage& s, Random& random) {
  return draw_debris(s.camera, s.center_px, make_mark(Shape::Disc, s.mark.radius_px), 0.3, random);
}

Features wrong_pads(const Stage& s, Random& random) {
  Features features;
  const double factor =
      random.uniform() < 0.5 ? random.uniform(0.5, 0.92) : random.uniform(1.08, 1.5);
  const double pitch_px = 2.6 * s.mark.radius_px * std::max(1.0, factor);
  for (int j = -2; j <= 2; ++j) {
    for (int i = -3; i <= 3; ++i) {
      const Stage moved{
          s.camera, s.mark, s.center_px + pitch_px * Eigen::Vector2d(i, j), s.level, s.background};
      for (const Feature& f : scaled_mark(moved, factor)) features.push_back(f);
    }
  }
  return features;
}

std::vector<Impostor> common_impostors() {
  return {
      {"bare board", [](const Stage&, Random&) { return Features{}; }},
      {"too small", [](const Stage& s, Random& r) { return scaled_mark(s, r.uniform(0.4, 0.92)); }},
      {"too small by 8 %",
       [](const Stage& s, Random& r) { return scaled_mark(s, r.uniform(0.90, 0.92)); }},
      {"too large", [](const Stage& s, Random& r) { return scaled_mark(s, r.uniform(1.08, 1.8)); }},
      {"too large by 8 %",
       [](const Stage& s, Random& r) { return scaled_mark(s, r.uniform(1.08, 1.10)); }},
      {"half", half_mark},
      {"over the border", mark_over_border},
      {"wrong polarity",
       [](const Stage& s, Random&) {
         Stage turned{s.camera, s.mark, s.center_px, 2 * s.background - s.level, s.background};
         return scaled_mark(turned, 1);
       }},
      {"oblong", oblong},
      {"hexagon", hexagon},
      {"tracks", tracks},
      {"board edge", board_edge},
      {"clutter", clutter},
      {"debris in a circle", debris_circle},
      {"many pads of a wrong size", wrong_pads},
      {"tilted", [](const Stage& s, Random&) { return scaled_mark(s, 1); }, true},
  };
}

/// A square, cross or diamond of about the same size or area.
Features cornered(const Stage& s, Shape shape, Random& r) {
  return shape_instead(s, shape, s.mark.radius_px * r.uniform(0.8, 1.2), r.uniform(-4, 4));
}

void add_other_shapes(Shape shape, std::vector<Impostor>& all) {
  const bool is_disc = shape == Shape::Disc || shape == Shape::Hole;
  if (!is_disc) {
    all.push_back({"disc", [](const Stage& s, Random& r) {
                     return shape_instead(s, Shape::Disc, s.mark.radius_px * r.uniform(0.9, 1.3));
                   }});
  }
  // A ring is a disc with a hole in it, which drilled pads have.
  if (shape != Shape::Ring && !is_disc) {
    all.push_back({"ring", [](const Stage& s, Random& r) {
                     Mark ring = make_mark(Shape::Ring, s.mark.radius_px);
                     ring.inner_radius_px = r.uniform(0.3, 0.85) * ring.radius_px;
                     return features_of(ring, s.camera, s.center_px, s.level);
                   }});
  }
  if (shape == Shape::Ring) {
    all.push_back({"ring with another hole", [](const Stage& s, Random& r) {
                     Mark ring = s.mark;
                     ring.inner_radius_px *=
                         r.uniform() < 0.5 ? r.uniform(0.4, 0.8) : r.uniform(1.2, 1.6);
                     return features_of(ring, s.camera, s.center_px, s.level);
                   }});
  }
  for (const Shape other : {Shape::Square, Shape::Diamond, Shape::Cross}) {
    if (other == shape) continue;
    all.push_back({std::string(name(other)),
                   [other](const Stage& s, Random& r) { return cornered(s, other, r); }});
  }
  if (shape == Shape::Square || shape == Shape::Diamond) {
    all.push_back({"rectangle", [](const Stage& s, Random& r) {
                     return Features{rectangle_at(s.camera,
                                                  s.center_px,
                                                  2 * s.mark.radius_px,
                                                  2 * s.mark.radius_px * r.uniform(0.5, 0.85),
                                                  r.uniform(0, kPi),
                                                  s.level)};
                   }});
  }
  if (shape == Shape::Cross) {
    all.push_back({"cross with other bars", [](const Stage& s, Random& r) {
                     Mark cross = s.mark;
                     cross.bar_width_px *=
                         r.uniform() < 0.5 ? r.uniform(0.4, 0.75) : r.uniform(1.3, 2);
                     return features_of(cross, s.camera, s.center_px, s.level);
                   }});
    all.push_back(
        {"a bar", [](const Stage& s, Random&) {
           return Features{rectangle_at(
               s.camera, s.center_px, 2 * s.mark.radius_px, s.mark.bar_width_px, 0, s.level)};
         }});
  }
}

}  // namespace

std::vector<Impostor> impostors_of(Shape shape) {
  std::vector<Impostor> all = common_impostors();
  add_other_shapes(shape, all);
  return all;
}

}  // namespace panelcal::bench
