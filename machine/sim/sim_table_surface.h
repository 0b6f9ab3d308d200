// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "machine/sim/simulated_probe.h"
#include <Eigen/Core>

namespace panelcal {

/// The table's own surface, which moves from night to night: the hidden truth of a night's probing.
struct SimTableSurface {
  SimulatedProbeOptions surface;     ///< as it is at `since`; in machine coordinates
  std::chrono::sys_seconds since{};  ///< before that it stands still
  Length height_per_day;             ///< what it rises by
  Eigen::Vector2d slope_ppm_per_day = Eigen::Vector2d::Zero();
  std::optional<SimulatedChip> chip;  ///< that is not there from the beginning
  std::chrono::sys_seconds chip_since{};

  /// The surface at a time. Its probe's noise is another one each second, and the same again if
  /// asked for the same time.
  SimulatedProbeOptions at(std::chrono::sys_seconds time) const;
};

}  // namespace panelcal
