// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/align/measure.h"
#include "machine/config/machine_config.h"
#include "machine/job/alignment_check.h"
#include "program/gcode/mover.h"

namespace panelcal::align {

/// The places of an aligned panel in the coordinates that its machine is told: relative to work
/// zero, with the error of the table taken out.
class MachinePlaces final : public BoardPlaces {
 public:
  /// Precondition: both outlive this.
  MachinePlaces(const AlignedPanel& panel, const MachineConfig& machine)
      : panel_(panel), walk_(machine.walk) {}

  Eigen::Vector2d actual_mm(const Eigen::Vector2d& nominal_mm) const override;
  /// Fails  travel-exceeded: beyond the table's map
  Expected<Length> sigma(const Eigen::Vector2d& nominal_mm) const override;

 private:
  Position<frame::Machine> in_machine(const Position<frame::Actual>& place) const {
    return configured_zero(walk_) + displacement_mm<frame::Machine>(place.in_mm());
  }

  const AlignedPanel& panel_;
  const WalkOptions& walk_;
};

}  // namespace panelcal::align
