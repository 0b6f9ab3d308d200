// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// A hole, or a round clamp.
struct Circle {
  Position<frame::Nominal> center;
  Length radius;
};

/// Corners in order, either way round; the last is joined to the first.
struct Polygon {
  std::vector<Position<frame::Nominal>> corners;
};

/// The area that a router of a width takes away on its way from point to point.
struct Track {
  std::vector<Position<frame::Nominal>> points;
  Length width;
};

/// All but a polygon: what lies beyond the edge of a panel.
struct Outside {
  Polygon panel;
};

/// A part of the table plane.
using Area = std::variant<Circle, Polygon, Track, Outside>;

Polygon rectangle(const Position<frame::Nominal>& low, const Position<frame::Nominal>& high);

/// That an area is one: numbers up to 1e6 mm, a radius or width above 0, a track of 1 to 10,000
/// points, a polygon of 3 to 2000 corners whose sides do not cross.
///
/// In     name: who it is, for the message
/// Fails  config-value
Expected<void> check_area(const Area& area, std::string_view name, const Place& from);

/// True if a place lies in an area, or nearer to it than margin. The border belongs to it.
bool is_within(const Area& area, const Position<frame::Nominal>& place, Length margin = mm(0));

/// Lower left and upper right corner of the rectangle about an area; infinite for Outside.
struct AreaBox {
  Eigen::Vector2d low_mm, high_mm;
};
AreaBox box_of(const Area& area);

}  // namespace panelcal
