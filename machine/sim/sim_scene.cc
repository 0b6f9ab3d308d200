// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/render/scene_marks.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Neighbours are this much smaller or larger than the target: beyond the widest size_tolerance.
constexpr double kSmallest = 0.3;
constexpr double kSmall = 0.45;
constexpr double kLarge = 1.7;
constexpr double kLargest = 2.0;
/// Copper is kept free around fiducials; nearer pads would be part of the target's rim.
constexpr double kClearance_px = 15;
constexpr int kMaxAttempts = 200;
/// Pictures that are blurred more show nothing, and take long to draw.
constexpr double kWidestBlur_px = 20;

double mark_level(const SimConfig& sim, const Target& target) {
  return target.polarity == Polarity::Bright ? sim.target_level
                                             : std::max(0.0, 2 * sim.background - sim.target_level);
}

Target resized(Target target, double ratio) {
  if (target.size) target.size = ratio * *target.size;
  if (target.size_px) target.size_px = ratio * *target.size_px;
  if (target.width) target.width = ratio * *target.width;
  if (target.width_px) target.width_px = ratio * *target.width_px;
  return target;
}

/// True if a round pad at a place is clear of a feature by `clearance_mm`.
bool is_clear(const Position<frame::Optical>& at,
              double radius_mm,
              const Feature& feature,
              double clearance_mm) {
  const Eigen::Vector2d d_mm = (at - feature.center).in_mm();
  const double least_mm = radius_mm + clearance_mm;
  if (feature.shape == Feature::Shape::Stadium) {  // long: a circle about it would fill pictures
    const double c = std::cos(feature.angle.in_rad());
    const double s = std::sin(feature.angle.in_rad());
    return std::abs(c * d_mm.x() + s * d_mm.y()) > 0.5 * feature.size.in_mm() + least_mm ||
           std::abs(c * d_mm.y() - s * d_mm.x()) > 0.5 * feature.inner_size.in_mm() + least_mm;
  }
  return d_mm.norm() > reach_of({feature}, feature.center).in_mm() + least_mm;
}

}  // namespace

Expected<Target> sim_target(const MachineConfig& config, int vision_tool) {
  const Place place{config.file.string(), 0, 0};
  if (!config.sim || !config.camera) {
    return failure({Code::ConfigValue,
                    place,
                    "[sim] or [camera] is missing, which describe the virtual machine",
                    "[sim] and [camera]"});
  }
  const auto target = config.vision_tools.find(vision_tool);
  if (target == config.vision_tools.end()) {
    return failure({Code::VisionToolUndefined,
                    place,
                    fmt::format("vision tool {}", vision_tool),
                    "a [[vision.tool]] of that number"});
  }
  return target->second;
}

Camera sim_camera(const SimConfig& sim, const CameraMapping& calibrated) {
  Camera camera{.mapping = sim.camera ? CameraMapping(*sim.camera) : calibrated};
  const double levels = sim.full_scale / Image::kFullScale8;
  camera.width = sim.width_px;
  camera.height = sim.height_px;
  camera.blur_px = sim.blur_px;
  camera.noise = sim.noise * levels;
  camera.full_scale = sim.full_scale;
  camera.shot_noise = sim.shot_noise * levels;
  camera.hot_pixels = sim.hot_pixels;
  camera.hot_pixels_at = sim.seed;
  camera.tilt = sim.tilt;
  camera.tilt_axis = sim.tilt_axis;
  return camera;
}

double blur_px_at(const SimConfig& sim, Length focus, const Camera& camera) {
  if (!sim.focus_z) return camera.blur_px;
  const Length defocus = focus - *sim.focus_z;
  const double wider = std::hypot(1, defocus.in_mm() / sim.focus_depth.in_mm());
  return std::min(kWidestBlur_px, wider * camera.blur_px);
}

Scene sim_scene(const SimConfig& sim) {
  Scene scene;
  scene.background = sim.background;
  scene.light_gradient = {sim.light_gradient, sim.light_gradient_y};
  scene.vignetting = sim.vignetting;
  scene.weave.amplitude = sim.weave_amplitude;
  scene.weave.period = sim.weave_period;
  scene.weave.seed = sim.seed;
  return scene;
}

std::vector<Feature> sim_mark(const SimConfig& sim,
                              const Target& target,
                              const SimMarkPlace& place,
                              const CameraMapping& calibrated,
                              Random random) {
  MarkLook look;
  look.center = place.center;
  look.turn = place.turn;
  look.level = mark_level(sim, target);
  look.ground = sim.background;
  look.slot_length = sim.slot_length.value_or(place.slot_length);
  look.burrs.rms = sim.burrs;
  look.burrs.seed = static_cast<std::uint64_t>(random.uniform() * 0x1p53);
  const double dx_mm = sim.ring_offset_sigma.in_mm() * random.normal();
  const double dy_mm = sim.ring_offset_sigma.in_mm() * random.normal();
  look.hole_offset = displacement_mm<frame::Optical>(dx_mm, dy_mm);
  return mark_features(target, look, calibrated);
}

void add_neighbors(const SimConfig& sim,
                   const Target& target,
                   const Camera& camera,
                   const CameraMapping& calibrated,
                   Random random,
                   std::vector<Feature>& features) {
  Target other = target;
  if (target.shape != Shape::Square && target.shape != Shape::Diamond &&
      target.shape != Shape::Cross) {
    other.shape = Shape::Disc;
  }
  MarkLook look;
  look.level = mark_level(sim, target);
  const double clearance_mm = kClearance_px * camera.mapping.parameters().scale_mm_per_px;
  for (int n = 0, attempts = 0; n < sim.neighbors && attempts < kMaxAttempts; ++attempts) {
    const double x_px = random.uniform(0, camera.width);
    const double y_px = random.uniform(0, camera.height);
    const double ratio = random.uniform() < 0.5 ? random.uniform(kSmallest, kSmall)
                                                : random.uniform(kLarge, kLargest);
    look.center = camera.mapping(position_px(x_px, y_px));
    const std::vector<Feature> pad = mark_features(resized(other, ratio), look, calibrated);
    const double radius_mm = reach_of(pad, look.center).in_mm();
    const bool is_free = std::ranges::all_of(features, [&](const Feature& feature) {
      return is_clear(look.center, radius_mm, feature, clearance_mm);
    });
    if (!is_free) continue;
    features.insert(features.end(), pad.begin(), pad.end());
    ++n;
  }
}

}  // namespace panelcal::internal
