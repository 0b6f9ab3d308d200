// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/frames.h"
#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "machine/config/settings/sim_options.h"
#include <Eigen/Core>

namespace panelcal {

namespace internal {

/// The stage of a virtual machine, and its clock, which only `wait` moves.
class SimMotion {
 public:
  SimMotion(const SimStops& stops, Random random) : stops_(stops), random_(random) {}

  /// In     error_mm: of the stage at this place, on top of how it stops
  /// Out    where it believes to stand: where it was sent
  Position<frame::Machine> move_to(const Position<frame::Machine>& spindle,
                                   const Eigen::Vector2d& error_mm = Eigen::Vector2d::Zero());
  /// True place of the spindle now, and the place at which it comes to rest.
  Position<frame::Machine> standing() const;
  const Position<frame::Machine>& rest() const { return rest_; }

  void wait(Time time) { now_ = now_ + time; }
  Time now() const { return now_; }

 private:
  SimStops stops_;
  Random random_;
  Time now_;
  Time arrived_;
  Position<frame::Machine> commanded_;
  Position<frame::Machine> rest_;
  Eigen::Vector2d way_ = Eigen::Vector2d::Zero();        ///< direction of the last move
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();  ///< the same per axis: -1, 0, 1
};

}  // namespace internal

}  // namespace panelcal
