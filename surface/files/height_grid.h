// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "surface/files/probe_file.h"
#include "surface/map/height_lattice.h"
#include "surface/map/height_map.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// Heights at evenly spaced nodes, for the files of programs that know only these.
struct HeightGrid {
  LatticeAxis x, y;
  std::vector<std::optional<Length>> heights;  ///< row by row; empty: nothing is known

  /// Fails  grid-invalid: fewer than two columns or rows, steps not above 0, another number of
  ///        heights than nodes, a number that is not finite, no height at all
  Expected<void> validate() const;
};

/// Nodes that get a height from a map.
enum class GridFill : std::uint8_t {
  Measured,  ///< nodes that a probe vouches for (HeightSource::Measured); the others stay missing
  Filled,    ///< also where it is only predicted, between probes; never outside of their hull
};

/// A map's heights at the nodes of a grid.
///
/// Fails  grid-invalid: as HeightGrid::validate(); more than kMaxFileProbes nodes
Expected<HeightGrid> height_grid(const HeightMap& map,
                                 const LatticeAxis& x,
                                 const LatticeAxis& y,
                                 GridFill fill = GridFill::Measured);

/// The same of a map of zones; what lies in a void is filled at best, what in no zone missing.
Expected<HeightGrid> height_grid(const ZonedMap& map,
                                 const LatticeAxis& x,
                                 const LatticeAxis& y,
                                 GridFill fill = GridFill::Measured);

/// The heights of a file of a grid; missing nodes stay missing.
///
/// Fails  grid-invalid: the file's format has no grid, or a point is not one of its nodes
Expected<HeightGrid> height_grid(const ProbeFile& file);

}  // namespace panelcal
