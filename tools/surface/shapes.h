// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calib/base/json/facts.h"
#include "surface/map/zoned_map.h"

namespace panelcal::surface {

/// A column of a table of facts: an array, and packed above kMostPlainRows. Values that are not
/// finite are null in an array, and NaN where packed.
inline constexpr std::size_t kMostPlainRows = 10000;
facts::Json column(std::span<const double> values);
facts::Json column(std::span<const std::uint32_t> values);
/// Of words that repeat: {"words": ["measured", "filled"], "index": column}.
facts::Json word_column(std::span<const std::string> values);

/// [[x, y], ...]
facts::Json corners(std::span<const Position<frame::Nominal>> places);
/// Corners of an area that zones have, a circle's as a polygon.
facts::Json border(const Area& area);
/// Areas that no probe touches: how many there are, and their shapes.
facts::Json voids_facts(const Voids& voids);

/// True if the map of a zone has no surface at a place: another zone, or a void.
bool is_blank(const ZonedMap& map, std::size_t i_zone, const Position<frame::Nominal>& place);

/// The nodes of an even grid over the rectangle of an area, for pictures.
class PictureGrid {
 public:
  /// In     area: not empty; margin: by which the rectangle is wider on each side
  PictureGrid(std::span<const Eigen::Vector2d> area, Length margin);

  /// Row by row, from low y.
  std::vector<Position<frame::Nominal>> nodes() const;
  /// {"first_mm": [x, y], "step_mm": [x, y], "columns": n, "rows": n}
  facts::Json facts() const;

 private:
  Eigen::Vector2d low_mm_, step_mm_;
  int n_columns_, n_rows_;
};

}  // namespace panelcal::surface
