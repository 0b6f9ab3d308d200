// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/spindle/fit.h"

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
  bool has_entry_material = false;  ///< somebody has to lay it on before, and take it off after
  Approach drilling = {1, 1};
  /// How the stage comes to each look; as many looks as there are.
  std::vector<Approach> looking = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
  /// From so far along each axis: more than any backlash, less than the way to a clamp.
  Length approach_distance = mm(1);
  /// Which rows are used up; beside machine.toml.
  std::filesystem::path state_file = "coupon.json";
  Place place;  ///< of [coupon], for messages
};

/// Where a run drills that begins at `first`, which G39 says: rows_per_run rows of columns, row by
/// row; from right to left in every other row, so that no way is long.
std::vector<Position<frame::Machine>> places_from(const Coupon& coupon,
                                                  const Position<frame::Machine>& first);

/// The same at a row of the coupon, from 0.
std::vector<Position<frame::Machine>> places_of_row(const Coupon& coupon, int i_row);

/// "rows 4 to 10 of coupon "A" are free (7 of 10): 2 runs of 3 rows".
std::string free_rows_text(const Coupon& coupon, int n_used);

/// How many rows of the coupon are used up; 0 if it is unused.
///
/// Fails  json-syntax, calibration-invalid (the state file is damaged: which rows are free is not
///        guessed at); file-unreadable
Expected<int> used_rows(const Coupon& coupon);

/// Takes the rows of one run, and writes that down before anybody drills: whatever happens then,
/// no row is drilled twice.
///
/// Out    the first row, from 0
/// Fails  as used_rows; config-value (too few rows are left); device-write
/// See    tests/machine/calibrate/coupon_test.cc
Expected<int> take_rows(const Coupon& coupon);

/// "+x-y": comes to rest moving right and down. "-x" alone says nothing of y.
std::string text(const Approach& approach);
/// Whether `text` is one, and which.
std::optional<Approach> approach_from_text(std::string_view text);

}  // namespace panelcal
