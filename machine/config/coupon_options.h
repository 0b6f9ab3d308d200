// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/spindle/coupon.h"

namespace panelcal {

/// [coupon]: the piece of material that calibration holes are drilled into, a lattice of places
/// that is used up row by row.
///
/// Source CNC-7 manual, Vision System Autocalibration (G39: count, pitch, entry material)
struct Coupon {
  /// As written on it; another name is another coupon, with all its rows free.
  std::string name = "coupon";
  Position<frame::Machine> origin;  ///< of its first hole, where the spindle is sent to
  int columns = 3;                  ///< holes of a row, along x
  int rows = 10;                    ///< along y
  int rows_per_run = 3;             ///< drilled for one calibration, 1 to rows
  Length pitch = mm(5);             ///< from hole to hole; above 0
  int drill_tool = 1;
  int vision_tool = 1;              ///< with which holes are looked for
  bool has_entry_material = false;  ///< an operator lays it on before, and takes it off after
  Approach drilling = {1, 1};
  /// How the stage comes to each look; as many looks as there are.
  std::vector<Approach> looking = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
  /// From so far along each axis: more than any backlash, less than the way to a clamp.
  Length approach_distance = mm(1);
  /// Which rows are used up; beside machine.toml.
  std::filesystem::path state_file = "coupon.json";
  Place place;       ///< of [coupon], for messages
  Place rows_place;  ///< of its key `rows`, or of [coupon]
};

/// "+x-y": comes to rest moving right and down. "-x" alone says nothing of y.
std::string text(const Approach& approach);

/// Whether `text` is one, and which.
std::optional<Approach> approach_from_text(std::string_view text);

}  // namespace panelcal
