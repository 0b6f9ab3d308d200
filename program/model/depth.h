// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// The control of the Z axis that a stroke is made under.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.1 (G71), 11 (G82, G83)
enum class DepthControl : std::uint8_t {
  Standard,  ///< G82, which every program begins with: planes count from the table plane Z0
  Depth,     ///< G83, and [[depth]]: depths count from the board's surface
  Slm,       ///< G71: depths count from the reference surface that the program has probed
};

/// The place that a stroke's working plane counts from.
enum class DepthReference : std::uint8_t {
  Table,  ///< the table plane Z0, or the machine's own set-up
  Board,  ///< the board's surface where the stroke meets it
  Plane,  ///< a height above the table, probed or by a map
  Grid,   ///< the table plane, raised and lowered by a probed grid
};

/// A measured height that planes count from, and where it was measured.
struct PlaneReference {
  Position<frame::Nominal> place;
  Length height;
  std::vector<Length> other_heights = {};  ///< under the second Z axis and further ones

  friend bool operator==(const PlaneReference&, const PlaneReference&) = default;
};

/// A measured height, a filled one and so on: surface/map/height_map.h.
enum class HeightSource : std::uint8_t;

/// Certainty of a height that is not probed at this place.
struct PredictedHeight {
  Length sigma;
  HeightSource source;

  friend bool operator==(const PredictedHeight&, const PredictedHeight&) = default;
};

/// The depth state of one stroke: all that decides how deep the tool works, and how far the Z axis
/// may go. A number that is absent is the operator's: the program (or [[depth]]) states none, so
/// that the value set by hand counts.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 8.2 (H, K, Z), 10, 11; CNC-7 manual, Depth Offset
struct DepthOfCut {
  std::optional<Length> z;        ///< standard control: of the tool's tip above the table plane
  std::optional<Length> depth;    ///< depth control, SLM: below the surface; < 0: a residual web
  std::optional<Length> surface;  ///< measured height of the surface that `depth` refers to
  /// Of a grid that z follows: z was moved by surface - reference. Outputs do not have it.
  std::optional<PlaneReference> reference = std::nullopt;
  /// The surface under the second Z axis and further ones; empty: there is one, or one map for all.
  std::vector<Length> other_surfaces = {};
  /// Of a surface that a map gives (--surface); absent where the program probed it.
  std::optional<PredictedHeight> predicted = std::nullopt;
  DepthControl control = DepthControl::Standard;
  /// Depth control, SLM: the tip goes no lower than this above the table plane (Z).
  std::optional<Length> lower_limit = std::nullopt;
  /// The Z axis goes no higher than this above the table plane (H).
  std::optional<Length> upper_limit = std::nullopt;

  bool is_controlled() const { return control != DepthControl::Standard; }
  DepthReference counts_from() const {
    if (is_controlled()) return surface ? DepthReference::Plane : DepthReference::Board;
    return surface ? DepthReference::Grid : DepthReference::Table;
  }
  /// Nothing is said; the same as == DepthOfCut(), and every hole is asked.
  bool is_empty() const {
    return !z && !depth && !surface && !reference && other_surfaces.empty() && !predicted &&
           !is_controlled() && !lower_limit && !upper_limit;
  }
  friend bool operator==(const DepthOfCut&, const DepthOfCut&) = default;
};

/// The depth between two depths; where one of them is unknown, `to`.
DepthOfCut interpolate(const DepthOfCut& from, const DepthOfCut& to, double fraction);

/// standard, depth or slm: the `control` of output files.
std::string_view name(DepthControl control);
/// table, board, plane or grid: the `reference` of output files.
std::string_view name(DepthReference reference);
/// measured, filled, extrapolated or void: the `surface_source` of output files.
std::string_view name(HeightSource source);

}  // namespace panelcal
