// SPDX-License-Identifier: Apache-2.0
#include "tools/align/machine_places.h"

#include "calib/correction/max_sigma.h"
#include "calib/correction/table_correction.h"

namespace panelcal::align {

Eigen::Vector2d MachinePlaces::actual_mm(const Eigen::Vector2d& nominal_mm) const {
  const Position<frame::Actual> place =
      panel_.place_of(position_mm<frame::Nominal>(nominal_mm)).position;
  if (walk_.table == nullptr) return place.in_mm();
  return (walk_.table->nearest_command_for(in_machine(place)) - configured_zero(walk_)).in_mm();
}

Expected<Length> MachinePlaces::sigma(const Eigen::Vector2d& nominal_mm) const {
  const auto place = panel_.place_of(position_mm<frame::Nominal>(nominal_mm));
  if (walk_.table != nullptr) {
    const Position<frame::Machine> at = in_machine(place.position);
    if (!walk_.table->command_for(at)) return failure(walk_.table->refusal(at));
  }
  MaxSigma largest;
  largest.add(place.cov);
  return largest.value();
}

}  // namespace panelcal::align
