// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/tolerance.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal {
namespace {

Length room(const AnnularRing& ring, Length drill) {
  return (ring.pad - drill) / 2 - ring.least;
}

bool says_position(const ToolTolerance& row) {
  return row.position || row.ring;
}

bool says_depth(const ToolTolerance& row) {
  return !row.depth.is_empty();
}

}  // namespace

/// As in [[diameter_page]].
bool is_same_drill(Length a, Length b) {
  return std::abs((a - b).in_um()) <= 0.5;
}

const ToolTolerance* Tolerances::row_of(int tool,
                                        std::optional<Length> diameter,
                                        bool (*says)(const ToolTolerance&)) const {
  const auto numbered = std::ranges::find_if(
      tools, [&](const ToolTolerance& row) { return row.number == tool && says(row); });
  if (numbered != tools.end()) return &*numbered;
  const auto sized = std::ranges::find_if(tools, [&](const ToolTolerance& row) {
    return !row.number && diameter && row.drill && is_same_drill(*row.drill, *diameter) &&
           says(row);
  });
  return sized == tools.end() ? nullptr : &*sized;
}

bool Tolerances::asks_positions() const {
  return position || std::ranges::any_of(tools, says_position);
}

bool Tolerances::asks_depths() const {
  return !depth.is_empty() || std::ranges::any_of(tools, says_depth);
}

DepthTolerance Tolerances::depth_of(int tool, std::optional<Length> diameter) const {
  const ToolTolerance* row = row_of(tool, diameter, says_depth);
  return row == nullptr ? depth : row->depth;
}

std::optional<Length> Tolerances::radius(int tool, std::optional<Length> diameter) const {
  const ToolTolerance* row = row_of(tool, diameter, says_position);
  if (row == nullptr) return position;
  if (!problem(tool, diameter).empty()) return std::nullopt;
  if (row->position) return row->position;
  return room(*row->ring, diameter ? *diameter : *row->drill);
}

std::string Tolerances::problem(int tool, std::optional<Length> diameter) const {
  const ToolTolerance* row = row_of(tool, diameter, says_position);
  if (row == nullptr) return {};
  if (row->drill && diameter && !is_same_drill(*row->drill, *diameter)) {
    return fmt::format("tool {} has {:.4g} mm in the program and {:.4g} mm in [[tolerance.tool]]",
                       tool,
                       diameter->in_mm(),
                       row->drill->in_mm());
  }
  if (row->position) return {};
  const std::optional<Length> drill = diameter ? diameter : row->drill;
  if (!drill) {
    return fmt::format("tool {} has no diameter, so its annular ring is not known", tool);
  }
  // Less is rounding.
  constexpr Length kLeastRoom = um(1e-3);
  if (room(*row->ring, *drill) >= kLeastRoom) return {};
  return fmt::format("a {:.4g} mm hole in a {:.4g} mm pad has no room beside a ring of {:.4g} um",
                     drill->in_mm(),
                     row->ring->pad.in_mm(),
                     row->ring->least.in_um());
}

}  // namespace panelcal
