// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_eye.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "machine/sim/sim_scene.h"

namespace panelcal::internal {

SimEye::SimEye(const MachineConfig& config, Random noise)
    : sim_(*config.sim),
      calibrated_(config.camera->mapping()),
      camera_(sim_camera(*config.sim, calibrated_)),
      noise_(noise),
      focus_(config.vision.focus.value_or(Length())) {
}

void SimEye::look_through(const MachineConfig& config) {
  sim_ = *config.sim;
  calibrated_ = config.camera->mapping();
  camera_ = sim_camera(sim_, calibrated_);
}

bool SimEye::has(CameraSetting setting) const {
  return (setting == CameraSetting::Lamp && sim_.lamp) ||
         (setting == CameraSetting::Focus && sim_.focus_z);
}

void SimEye::set(CameraSetting setting, double value) {
  if (!has(setting)) return;
  if (setting == CameraSetting::Lamp) lamp_ = value / *sim_.lamp;
  if (setting == CameraSetting::Focus) focus_ = mm(value);
}

Image SimEye::picture(const Position<frame::Machine>& axis, const std::vector<SimSeenMark>& marks) {
  Camera camera = camera_;
  camera.blur_px = blur_px_at(sim_, focus_, camera);
  const double view_mm =
      std::hypot(camera.width, camera.height) * camera.mapping.parameters().scale_mm_per_px;
  Scene scene = sim_scene(sim_);
  scene.lamp = std::max(0.0, lamp_);
  for (const SimSeenMark& mark : marks) {
    const Eigen::Vector2d from_axis_mm = (mark.place - axis).in_mm();
    // Farther away than a whole picture nothing shows: marks are smaller than pictures.
    if (from_axis_mm.norm() > view_mm) continue;
    SimMarkPlace place;
    place.center = position_mm<frame::Optical>(from_axis_mm);
    place.turn = mark.turn;
    for (Feature& feature : sim_mark(sim_, mark.target, place, calibrated_, mark.random)) {
      scene.features.push_back(std::move(feature));
    }
  }
  return render(scene, camera, noise_);
}

}  // namespace panelcal::internal
