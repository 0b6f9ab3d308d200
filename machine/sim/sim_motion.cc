// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_motion.h"

#include <cmath>
#include <numbers>

namespace panelcal::internal {

Position<frame::Machine> SimMotion::move_to(const Position<frame::Machine>& spindle,
                                            const Eigen::Vector2d& error_mm) {
  const Eigen::Vector2d way_mm = (spindle - commanded_).in_mm();
  if (way_mm.norm() > 0) {
    way_ = way_mm.normalized();
    arrived_ = now_;
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (way_mm[axis] != 0) direction_[axis] = way_mm[axis] > 0 ? 1 : -1;
  }
  commanded_ = spindle;
  Eigen::Vector2d off_mm = error_mm - 0.5 * stops_.backlash.in_mm().cwiseProduct(direction_);
  const double sigma_mm = stops_.stage_repeatability.in_mm();
  off_mm.x() += sigma_mm * random_.normal();
  off_mm.y() += sigma_mm * random_.normal();
  rest_ = spindle + displacement_mm<frame::Machine>(off_mm);
  return commanded_;
}

Position<frame::Machine> SimMotion::standing() const {
  const double t_s = (now_ - arrived_).in_s();
  const double swing_mm = stops_.swing.in_mm() * std::exp(-t_s / stops_.swing_decay.in_s()) *
                          std::cos(2 * std::numbers::pi * stops_.swing_hz * t_s);
  return rest_ + displacement_mm<frame::Machine>((swing_mm * way_).eval());
}

}  // namespace panelcal::internal
