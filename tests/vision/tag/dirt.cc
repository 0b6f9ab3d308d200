// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/tag/dirt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace panelcal::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// Depth of a place inside of the patch, px; negative outside. Near the edge it is exact for
/// rectangles and good for round patches.
double depth_px(const Patch& patch, const Eigen::Vector2d& at) {
  const Eigen::Vector2d v = Eigen::Rotation2Dd(-patch.angle_rad) * (at - patch.center_px);
  if (!patch.is_round) return (patch.half_px - v.cwiseAbs()).minCoeff();
  const double r = v.cwiseQuotient(patch.half_px).norm();
  return (1 - r) * patch.half_px.minCoeff();
}

/// Pieces of an area or a line that are covered.
class Covered {
 public:
  explicit Covered(std::vector<Eigen::Vector2d> places)
      : places_(std::move(places)), is_covered_(places_.size(), false) {}

  void add(const Patch& patch) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (depth_px(patch, places_[i]) > 0) is_covered_[i] = true;
    }
  }
  double part() const {
    return static_cast<double>(std::count(is_covered_.begin(), is_covered_.end(), true)) /
           static_cast<double>(places_.size());
  }

 private:
  std::vector<Eigen::Vector2d> places_;
  std::vector<bool> is_covered_;
};

Eigen::Vector2d on_outline(double turn) {
  const double t = 4 * turn;
  const double along = t - std::floor(t) - 0.5;
  switch (static_cast<int>(t) % 4) {
    case 0:
      return {along, -0.5};
    case 1:
      return {0.5, along};
    case 2:
      return {-along, 0.5};
    default:
      return {-0.5, -along};
  }
}

std::vector<Eigen::Vector2d> tag_places(const TagScene& scene, DirtPlace place) {
  constexpr int kSteps = 80;
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) / kSteps;
    if (place == DirtPlace::Rim) {
      for (int k = 0; k < 4; ++k) {
        places.push_back(project(scene.image_from_tag, on_outline(0.25 * (k + u))));
      }
      continue;
    }
    for (int k = 0; k < kSteps; ++k) {
      places.push_back(project(scene.image_from_tag, {u - 0.5, (k + 0.5) / kSteps - 0.5}));
    }
  }
  return places;
}

}  // namespace

std::vector<Patch> draw_dirt(
    const TagScene& scene, DirtPlace place, double part, int n_scratches, Random& random) {
  std::vector<Patch> patches;
  Covered covered(tag_places(scene, place));
  while (covered.part() < part) {
    Eigen::Vector2d at(random.uniform(-0.5, 0.5), 0);
    at.y() = random.uniform(-0.5, 0.5);
    if (place == DirtPlace::Rim) at = on_outline(random.uniform());
    Patch patch;
    patch.center_px = project(scene.image_from_tag, at);
    patch.half_px.x() = random.uniform(1.5, 6);
    patch.half_px.y() = random.uniform(1.5, 6);
    patch.angle_rad = random.uniform(0, kPi);
    patch.level = random.uniform(0, 255);
    patch.is_round = random.uniform() < 0.5;
    patches.push_back(patch);
    covered.add(patch);
  }
  for (int i = 0; i < n_scratches; ++i) {
    Eigen::Vector2d at(random.uniform(-0.4, 0.4), 0);
    at.y() = random.uniform(-0.4, 0.4);
    Patch scratch;
    scratch.center_px = project(scene.image_from_tag, at);
    scratch.half_px.x() = random.uniform(20, 60);
    scratch.half_px.y() = random.uniform(0.5, 1.2);
    scratch.angle_rad = random.uniform(0, kPi);
    scratch.level = random.uniform() < 0.5 ? scene.black : scene.white + 20;
    patches.push_back(scratch);
  }
  return patches;
}

std::vector<Patch> draw_tag_neighbours(const TagScene& scene, int n, Random& random) {
  const double reach = -1.0 * scene.pattern.lines.front();
  std::vector<Patch> patches;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d rim = on_outline(random.uniform()) * 2 * reach;
    const Eigen::Vector2d rim_px = project(scene.image_from_tag, rim);
    Patch patch;
    patch.half_px.x() = random.uniform(8, 25);
    patch.half_px.y() = random.uniform(8, 25);
    patch.is_round = random.uniform() < 0.5;
    patch.angle_rad = random.uniform(0, kPi);
    patch.level = random.uniform() < 0.5 ? scene.black : scene.white;
    const double way_px = patch.half_px.norm() + random.uniform(6, 20);
    patch.center_px = rim_px + way_px * (rim_px - scene.center_px()).normalized();
    patches.push_back(patch);
  }
  return patches;
}

void paint(const TagScene& scene, const std::vector<Patch>& patches, std::vector<double>& levels) {
  const double sigma_px = std::hypot(scene.blur_px, 0.2887);
  const double unit = scene.full_scale / 255;
  for (const Patch& patch : patches) {
    const double reach = patch.half_px.norm() + 4 * sigma_px;
    const auto clamped = [](double v, int n) {
      return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(n)));
    };
    const int y1 = clamped(patch.center_px.y() + reach, scene.height);
    const int x1 = clamped(patch.center_px.x() + reach, scene.width);
    for (int y = clamped(patch.center_px.y() - reach, scene.height); y < y1; ++y) {
      for (int x = clamped(patch.center_px.x() - reach, scene.width); x < x1; ++x) {
        const double t = depth_px(patch, {x, y}) / sigma_px;
        // A patch narrower than the blur is fainter in the middle.
        const double wide = 2 * patch.half_px.minCoeff() / sigma_px;
        const double share =
            0.5 * (std::erf(t / std::numbers::sqrt2) - std::erf((t - wide) / std::numbers::sqrt2));
        double& level = levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene.width) +
                               static_cast<std::size_t>(x)];
        level += share * (patch.level * unit - level);
      }
    }
  }
}

}  // namespace panelcal::test
