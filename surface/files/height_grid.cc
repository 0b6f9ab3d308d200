// SPDX-License-Identifier: Apache-2.0
#include "surface/files/height_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace panelcal {
namespace {

Expected<void> check_axes(const LatticeAxis& x, const LatticeAxis& y) {
  for (const LatticeAxis* axis : {&x, &y}) {
    const bool is_good = axis->n_nodes >= 2 && axis->step_mm > 0 && std::isfinite(axis->first_mm) &&
                         std::isfinite(axis->last_mm());
    if (is_good) continue;
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("a grid along {} of {} nodes every {} mm from {} mm",
                                axis == &x ? 'x' : 'y',
                                axis->n_nodes,
                                axis->step_mm,
                                axis->first_mm),
                    "2 nodes or more, apart from each other"});
  }
  const auto n_columns = static_cast<std::size_t>(x.n_nodes);
  const auto n_rows = static_cast<std::size_t>(y.n_nodes);
  if (n_columns <= kMaxFileProbes / n_rows) return {};
  return failure({Code::GridInvalid,
                  {},
                  fmt::format("a grid of {} x {} nodes", n_columns, n_rows),
                  fmt::format("at most {} in all", kMaxFileProbes)});
}

/// The node nearest to a coordinate; empty beyond the ends.
std::optional<std::size_t> grid_node(const LatticeAxis& axis, double value_mm) {
  const double i = std::round((value_mm - axis.first_mm) / axis.step_mm);
  if (!(i >= 0 && i < axis.n_nodes)) return std::nullopt;
  return static_cast<std::size_t>(i);
}

bool is_wanted(HeightSource source, GridFill fill) {
  if (source == HeightSource::Measured) return true;
  return source != HeightSource::Extrapolated && fill == GridFill::Filled;
}

/// A node at which the map refuses has no height.
template <class HeightAtPlace>
Expected<HeightGrid> sampled(const LatticeAxis& x,
                             const LatticeAxis& y,
                             GridFill fill,
                             const HeightAtPlace& height_at) {
  PANELCAL_CHECK(check_axes(x, y));
  HeightGrid out{x, y, {}};
  for (int j = 0; j < y.n_nodes; ++j) {
    for (int i = 0; i < x.n_nodes; ++i) {
      const auto node = height_at(position_mm<frame::Nominal>(x.at_mm(i), y.at_mm(j)));
      const bool is_known = node && is_wanted(node->source, fill);
      out.heights.push_back(is_known ? std::optional(node->height) : std::nullopt);
    }
  }
  PANELCAL_CHECK(out.validate());
  return out;
}

}  // namespace

Expected<void> HeightGrid::validate() const {
  PANELCAL_CHECK(check_axes(x, y));
  const auto n_nodes = static_cast<std::size_t>(x.n_nodes) * static_cast<std::size_t>(y.n_nodes);
  if (heights.size() != n_nodes) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("{} heights of {} nodes", heights.size(), n_nodes),
                    "one for each, or that it is missing"});
  }
  const auto is_none = [](const std::optional<Length>& height) {
    return height && !std::isfinite(height->in_mm());
  };
  if (std::ranges::any_of(heights, is_none)) {
    return failure({Code::GridInvalid, {}, "a height of the grid is not finite", "finite numbers"});
  }
  if (std::ranges::any_of(heights, [](const auto& height) { return height.has_value(); }))
    return {};
  return failure({Code::GridInvalid, {}, "a grid without any height", "one or more"});
}

Expected<HeightGrid> height_grid(const HeightMap& map,
                                 const LatticeAxis& x,
                                 const LatticeAxis& y,
                                 GridFill fill) {
  return sampled(
      x, y, fill, [&](const Position<frame::Nominal>& place) { return map.height_at(place); });
}

Expected<HeightGrid> height_grid(const ZonedMap& map,
                                 const LatticeAxis& x,
                                 const LatticeAxis& y,
                                 GridFill fill) {
  return sampled(x, y, fill, [&](const Position<frame::Nominal>& place) {
    return map.height_at(place).map(&ZonedHeight::height);
  });
}

Expected<HeightGrid> height_grid(const ProbeFile& file) {
  if (!file.grid) {
    return failure({Code::GridInvalid,
                    {file.file, 0, 0},
                    fmt::format("a file of format {}", name_of(file.format)),
                    "one of a grid, such as heightmap, bcnc or opencncpilot"});
  }
  PANELCAL_CHECK(check_axes(file.grid->x, file.grid->y));
  HeightGrid out{file.grid->x, file.grid->y, {}};
  const auto n_columns = static_cast<std::size_t>(out.x.n_nodes);
  out.heights.resize(n_columns * static_cast<std::size_t>(out.y.n_nodes));
  for (const ProbePoint& point : file.points) {
    const auto column = grid_node(out.x, point.place.in_mm().x());
    const auto row = grid_node(out.y, point.place.in_mm().y());
    if (!column || !row) {
      return failure({Code::GridInvalid,
                      point.from,
                      fmt::format("{} beside its grid", quoted(point.name)),
                      "a probe of a node"});
    }
    out.heights[*row * n_columns + *column] = point.measured.height;
  }
  return out;
}

}  // namespace panelcal
