// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/walk/probing.h"

namespace panelcal {

/// Where something is broken out of a surface.
struct SimulatedChip {
  Position<frame::Actual> place;
  Length radius;
  Length depth;
};

/// What a simulated board is like, and the probe that touches it.
struct SimulatedProbeOptions {
  std::uint64_t seed = 1;
  Length height = mm(1.6);  ///< of the surface above Z0, at work zero
  double slope_x_ppm = 0;   ///< rise along x: 1000 is 1 mm in a metre
  double slope_y_ppm = 0;
  /// A bowl, or with a negative value a hill: how much the surface rises from bow_center to
  /// bow_radius away from it. The bow takes no part in `height`.
  Length bow;
  Position<frame::Actual> bow_center;  ///< relative to work zero
  Length bow_radius = mm(300);         ///< above 0
  std::optional<SimulatedChip> chip;   ///< radius and depth above 0
  /// What every Z axis reads too high, one per Z axis; at least one.
  std::vector<Length> axis_offsets = {Length()};
  Length noise_sigma = um(2);  ///< of one reading; 0 or more

  /// Fails  config-value, without a place
  Expected<void> validate() const;
};

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

  /// What an exact probe would read. Precondition: axis < the number of axis_offsets.
  Length true_height(const Position<frame::Actual>& place, std::size_t axis) const;

 private:
  explicit SimulatedProbe(SimulatedProbeOptions options);

  SimulatedProbeOptions options_;
};

}  // namespace panelcal
