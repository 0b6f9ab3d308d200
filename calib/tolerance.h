// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panelcal/calib/base/units.h"

namespace panelcal {

/// What is asked of a hole in a pad: a ring of copper all around it, at least this wide. The hole
/// breaks it when it is further than (pad - drill) / 2 - least from the pad's middle.
struct AnnularRing {
  Length pad;    ///< diameter
  Length least;  ///< width that must remain
};

/// What [[tolerance.tool]] says of one tool, or of all tools of one diameter. One of position and
/// ring.
struct ToolTolerance {
  std::optional<int> number;
  std::optional<Length> drill;  ///< with a number: the diameter of that tool
  std::optional<Length> position;
  std::optional<AnnularRing> ring;
};

/// How far holes may be from where they belong, and how sure one has to be of it: [tolerance].
struct Tolerances {
  std::optional<Length> position;    ///< radius, for tools that no row names
  std::vector<ToolTolerance> tools;  ///< rows with a number go before those with a diameter
  double warn_above = 1e-4;          ///< probability that a hole breaks its tolerance
  double hold_above = 1e-2;

  bool is_empty() const { return !position && tools.empty(); }
  /// How far a hole of this tool may be off; `diameter` is what the program says. Absent where
  /// nothing is asked of the tool, and where what is asked makes no sense.
  std::optional<Length> radius(int tool, std::optional<Length> diameter) const;
  /// Why what is asked of the tool makes no sense; empty if it does.
  std::string problem(int tool, std::optional<Length> diameter) const;

 private:
  const ToolTolerance* row_of(int tool, std::optional<Length> diameter) const;
};

}  // namespace panelcal
