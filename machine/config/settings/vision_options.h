// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/units.h"

namespace panelcal {

/// Places of the four views of G34,v1,delta and G34,v1,v2,v3,v4,delta about the target's middle, in
/// machine directions and in this order (docs/conventions.md).
enum class FourViews : std::uint8_t {
  Axes,     ///< (+delta, 0), (0, +delta), (-delta, 0), (0, -delta)
  Corners,  ///< (+delta, +delta), (-delta, +delta), (-delta, -delta), (+delta, -delta)
};

/// More inspections of one place than this are a typing error, not a wish.
inline constexpr int kMaxInspections = 100;

/// The heights between which the camera's focus axis may go.
struct FocusRange {
  Length low;
  Length high;
};

/// Options of the vision system that machine.toml states and programs do not.
struct VisionOptions {
  /// [vision] search_radius_mm: where a target may be, around the expected place. Absent: anywhere
  /// in the picture.
  std::optional<Length> search_radius;
  /// [vision] search_area_mm: radius of an autosearch without `$uvis,searcharea`. Absent: such a
  /// search looks no farther than an ordinary view.
  std::optional<Length> search_area;
  FourViews four_views = FourViews::Axes;  ///< [vision] four_views
  /// [vision] four_view_limit_um: how far a mark may be from where the other three have it, beyond
  /// three sigmas of its own; the panel's turn is taken out. Larger forgives worse etching, smaller
  /// finds sooner that a view saw another mark.
  Length four_view_limit = um(25);
  /// [vision] algorithms: numbers of `$uvis,alg` that mean this vision system. 0 is the manual's
  /// "Excellon Algorithm".
  std::vector<int> algorithms = {0};
  std::optional<FocusRange> focus_range;  ///< [camera] focus_range_mm; absent: no focus axis
  /// [camera] focus_mm: where the focus axis stands unless `$uvis,focus` has moved it. Absent:
  /// not stated, and it is left where it is.
  std::optional<Length> focus;
  /// [camera] lamp: the level for targets without an `$uvis,lamp`. Absent: as it is.
  std::optional<double> lamp;
};

}  // namespace panelcal
