// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/sim/sim_coupon.h"

#include <cmath>
#include <utility>

#include "panelcal/machine/sim/sim_scene.h"

namespace panelcal {
namespace {

Displacement<frame::Machine> draw(Random& random, Length sigma) {
  const double x_mm = sigma.in_mm() * random.normal();
  return displacement_mm<frame::Machine>(x_mm, sigma.in_mm() * random.normal());
}

}  // namespace

SimCoupon::SimCoupon(const MachineConfig& config, const SimCouponOptions& options, Target target)
    : sim_(*config.sim),
      options_(options),
      target_(std::move(target)),
      calibrated_(config.camera->mapping()),
      camera_(internal::sim_camera(*config.sim, calibrated_)),
      offset_{config.sim->spindle_camera_offset.value_or(config.spindle_camera.offset), {}},
      stops_(Random(options.seed).fork(1)),
      drills_(Random(options.seed).fork(2)),
      noise_(Random(options.seed).fork(3)) {
}

Expected<SimCoupon> SimCoupon::create(const MachineConfig& config,
                                      const SimCouponOptions& options) {
  PANELCAL_TRY(const Target target, internal::sim_target(config, options.vision_tool));
  return SimCoupon(config, options, target);
}

Expected<Position<frame::Machine>> SimCoupon::move_to(const Position<frame::Machine>& spindle) {
  const Eigen::Vector2d way_mm = (spindle - commanded_).in_mm();
  for (int axis = 0; axis < 2; ++axis) {
    if (way_mm[axis] != 0) direction_[axis] = way_mm[axis] > 0 ? 1 : -1;
  }
  commanded_ = spindle;
  const Eigen::Vector2d lag_mm = 0.5 * options_.backlash.in_mm().cwiseProduct(direction_);
  standing_ = spindle - displacement_mm<frame::Machine>(lag_mm) +
              draw(stops_, options_.stage_repeatability);
  return commanded_;
}

Expected<void> SimCoupon::drill(int /*tool*/) {
  holes_.push_back(standing_ + draw(drills_, options_.wander));
  return {};
}

Expected<Image> SimCoupon::take() {
  const Position<frame::Machine> axis = offset_.optical_axis(standing_);
  const double view_mm =
      std::hypot(camera_.width, camera_.height) * camera_.mapping.parameters().scale_mm_per_px;
  Scene scene = internal::sim_scene(sim_);
  for (std::size_t i = 0; i < holes_.size(); ++i) {
    const Eigen::Vector2d from_axis_mm = (holes_[i] - axis).in_mm();
    // Farther away than a whole picture nothing shows: tools are smaller than pictures.
    if (from_axis_mm.norm() > view_mm) continue;
    internal::SimMarkPlace place;
    place.center = position_mm<frame::Optical>(from_axis_mm);
    const Random burrs = Random(options_.seed).fork(100 + i);
    for (Feature& feature : internal::sim_mark(sim_, target_, place, calibrated_, burrs)) {
      scene.features.push_back(std::move(feature));
    }
  }
  return render(scene, camera_, noise_);
}

}  // namespace panelcal
