// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/units.h"

namespace panelcal {

/// Diameters are of one drill: in inches and in millimetres with few decimals they differ.
bool is_same_drill(Length a, Length b);

/// The requirement on a hole in a pad: a ring of copper all around it, at least this wide. The hole
/// breaks it when it is further than (pad - drill) / 2 - least from the pad's middle.
struct AnnularRing {
  Length pad;    ///< diameter
  Length least;  ///< width that must remain
};

/// The requirement on depths below the board's surface; above 0. An absent side is not judged.
struct DepthTolerance {
  std::optional<Length> too_shallow;  ///< more than this less deep than wanted
  std::optional<Length> too_deep;     ///< more than this deeper: through to what lies below

  bool is_empty() const { return !too_shallow && !too_deep; }
};

/// A row [[tolerance.tool]], of one tool or of all tools of one diameter. At most one of
/// position and ring.
struct ToolTolerance {
  std::optional<int> number;
  std::optional<Length> drill;  ///< with a number: the diameter of that tool
  std::optional<Length> position;
  std::optional<AnnularRing> ring;
  DepthTolerance depth;
};

/// Greatest errors of holes in place and depth, and the required confidence: [tolerance].
struct Tolerances {
  std::optional<Length> position;    ///< radius, for tools of which no row says more
  DepthTolerance depth;              ///< likewise
  std::vector<ToolTolerance> tools;  ///< rows with a number go before those with a diameter
  double warn_above = 1e-4;          ///< probability that a hole breaks its tolerance
  double hold_above = 1e-2;

  bool asks_positions() const;
  bool asks_depths() const;
  /// Greatest error in place of a hole of this tool; `diameter` is what the program says. Absent
  /// where nothing is asked of the tool, and where problem() is not empty.
  std::optional<Length> radius(int tool, std::optional<Length> diameter) const;
  /// Greatest error of this tool's depths: all of the tool's row, if it says anything.
  DepthTolerance depth_of(int tool, std::optional<Length> diameter) const;
  /// The reason why the tool's tolerance is not valid; empty if it is.
  std::string problem(int tool, std::optional<Length> diameter) const;

 private:
  /// The row of those that say something of one kind.
  const ToolTolerance* row_of(int tool,
                              std::optional<Length> diameter,
                              bool (*says)(const ToolTolerance&)) const;
};

}  // namespace panelcal
