// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/config/settings/sim_options.h"
#include "program/walk/probing.h"

namespace panelcal {

/// A probe over a hidden surface.
///
///   z = height + slope_x x + slope_y y + bow (|p - bow_center| / bow_radius)^2 + offset + noise,
///
/// and `depth` less within a chip; p is the expected place of the request, where the machine drives
/// to, relative to work zero. Readings carry noise_sigma as their sigma. The noise is a function of
/// the seed, of the request's seq and of the Z axis, so the order of requests does not matter.
class SimulatedProbe final : public ProbeSource {
 public:
  /// Fails  config-value, without a place
  static Expected<SimulatedProbe> create(SimulatedProbeOptions options);

  Expected<ProbeReading> probe(const ProbeRequest& request) override;

  /// The reading of an exact probe. Precondition: axis < the number of axis_offsets.
  Length true_height(const Position<frame::Actual>& place, std::size_t axis) const;

 private:
  explicit SimulatedProbe(SimulatedProbeOptions options);

  SimulatedProbeOptions options_;
};

}  // namespace panelcal
