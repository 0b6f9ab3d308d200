// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/sim/sim_plate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "panelcal/machine/sim/sim_scene.h"

namespace panelcal {
namespace {

/// Pictures that are blurred more show nothing, and take long to draw.
constexpr double kWidestBlur_px = 40;

}  // namespace

SimPlate::SimPlate(const MachineConfig& config, SimPlateOptions options, Target target)
    : sim_(*config.sim),
      options_(std::move(options)),
      target_(std::move(target)),
      calibrated_(config.camera->mapping()),
      camera_(internal::sim_camera(*config.sim, calibrated_)),
      offset_{config.sim->spindle_camera_offset.value_or(config.spindle_camera.offset), {}},
      stops_(Random(options_.seed).fork(1)),
      noise_(Random(options_.seed).fork(2)) {
}

Expected<SimPlate> SimPlate::create(const MachineConfig& config, SimPlateOptions options) {
  PANELCAL_TRY(const Target target, internal::sim_target(config, options.vision_tool));
  return SimPlate(config, std::move(options), target);
}

Expected<Position<frame::Machine>> SimPlate::move_to(const Position<frame::Machine>& spindle) {
  const Eigen::Vector2d way_mm = (spindle - commanded_).in_mm();
  if (way_mm.norm() > 0) {
    direction_ = way_mm.normalized();
    arrived_ = now_;
  }
  commanded_ = spindle;
  Eigen::Vector2d off_mm = options_.error_mm ? options_.error_mm(spindle) : Eigen::Vector2d::Zero();
  const double sigma_mm = options_.stage_repeatability.in_mm();
  off_mm.x() += sigma_mm * stops_.normal();
  off_mm.y() += sigma_mm * stops_.normal();
  rest_ = spindle + displacement_mm<frame::Machine>(off_mm);
  return commanded_;
}

Expected<void> SimPlate::drill(int /*tool*/) {
  return failure(
      {Code::DeviceStage, {"sim", 0, 0}, "the virtual table with marks cannot be drilled", ""});
}

bool SimPlate::can_set(CameraSetting setting) const {
  return (setting == CameraSetting::Lamp && sim_.lamp) ||
         (setting == CameraSetting::Focus && sim_.focus_z);
}

Expected<void> SimPlate::set(CameraSetting setting, double value) {
  if (!can_set(setting)) return Stage::set(setting, value);
  if (setting == CameraSetting::Lamp) lamp_ = value / *sim_.lamp;
  if (setting == CameraSetting::Focus) focus_mm_ = value;
  return {};
}

Position<frame::Machine> SimPlate::standing() const {
  const double t_s = (now_ - arrived_).in_s();
  const double swing_mm = options_.swing.in_mm() * std::exp(-t_s / options_.swing_decay.in_s()) *
                          std::cos(2 * std::numbers::pi * options_.swing_hz * t_s);
  return rest_ + displacement_mm<frame::Machine>((swing_mm * direction_).eval());
}

Expected<Image> SimPlate::take() {
  const Position<frame::Machine> axis = offset_.optical_axis(standing());
  Camera camera = camera_;
  if (sim_.focus_z) {
    const double defocus_mm = focus_mm_ - sim_.focus_z->in_mm();
    const double wider = std::hypot(1, defocus_mm / sim_.focus_depth.in_mm());
    camera.blur_px = std::min(kWidestBlur_px, wider * camera.blur_px);
  }
  const double view_mm =
      std::hypot(camera.width, camera.height) * camera.mapping.parameters().scale_mm_per_px;
  Scene scene = internal::sim_scene(sim_);
  scene.lamp = std::max(0.0, lamp_);
  std::uint64_t i_mark = 0;
  const auto add = [&](const Target& target, const Position<frame::Machine>& mark, Angle turn) {
    const Random burrs = Random(options_.seed).fork(100 + i_mark++);
    const Eigen::Vector2d from_axis_mm = (mark - axis).in_mm();
    // Farther away than a whole picture nothing shows: marks are smaller than pictures.
    if (from_axis_mm.norm() > view_mm) return;
    internal::SimMarkPlace place;
    place.center = position_mm<frame::Optical>(from_axis_mm);
    place.turn = turn;
    for (Feature& feature : internal::sim_mark(sim_, target, place, calibrated_, burrs)) {
      scene.features.push_back(std::move(feature));
    }
  };
  for (const Position<frame::Machine>& mark : options_.marks) add(target_, mark, {});
  for (const SimOtherMark& other : options_.others) add(other.target, other.place, other.turn);
  return render(scene, camera, noise_);
}

}  // namespace panelcal
