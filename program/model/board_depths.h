// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "calib/base/units.h"

namespace panelcal {

class ZonedMap;

/// Depth of one tool, or all tools of one diameter: [[depth]].
struct ToolDepth {
  std::optional<int> number;
  std::optional<Length> drill;  ///< without a number: the diameter of the tools that are meant
  Length depth;                 ///< of the tool's tip below the board's surface
};

/// The job's data on the board that its program does not state.
struct BoardDepths {
  /// --surface: the board as it was probed before, above the table plane, on the first Z axis.
  /// Null: unknown.
  std::shared_ptr<const ZonedMap> map;
  std::vector<ToolDepth> tools;  ///< [[depth]]; rows with a number go before those with a diameter
  /// [surface] height_tolerance_um: how near to the surface lines and arcs keep that follow it, the
  /// map's or a probed grid's.
  Length height_tolerance = um(10);
  /// [surface] max_sigma_um: where the map is less sure no tool works to a depth.
  Length max_sigma = um(50);

  /// `diameter` is what the program says. Absent where no row names the tool.
  std::optional<Length> depth_of(int tool, std::optional<Length> diameter) const;
};

}  // namespace panelcal
