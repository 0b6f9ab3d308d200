// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/text/source_text.h"
#include "surface/map/height_map.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

struct LevelOptions {
  /// Between two cuts of a move the tool is this near to the height that it is meant to have.
  Length height_tolerance = um(10);
  /// Moves at or above this Z stay as they are. Empty: the lowest Z at which the program travels,
  /// of those above the board; rapid moves and cycles travel, if none does then any move.
  std::optional<Length> safe_height;
  /// Place of the tool when its Z was set to 0. Empty: the map's heights count from there already;
  /// a map whose heights are all more than 1 mm from 0 is then refused.
  std::optional<Position<frame::Nominal>> zero;
  /// The unit of coordinates before G20 and G21, mm; empty: such a program is refused.
  std::optional<double> unit_mm;
};

/// The changes to a program.
struct LevelFigures {
  Length safe_height;
  Length board;                 ///< its highest place, with three sigmas
  std::int64_t n_moves = 0;     ///< of X, Y or Z
  std::int64_t n_levelled = 0;  ///< of these
  std::int64_t n_pieces = 0;    ///< that the levelled ones have become
  Length lowest;                ///< of what was added to Z
  Length highest;
  std::int64_t n_filled = 0;        ///< levelled moves over places where a probe is missing
  std::int64_t n_extrapolated = 0;  ///< outside of the probes' hull
  std::int64_t n_over_voids = 0;    ///< over holes and the like, at the height predicted there
  Length largest_sigma;             ///< of the surface under a levelled move
  int line_of_largest_sigma = 0;
};

struct LevelledGcode {
  std::string text;
  LevelFigures figures;
};

/// Makes a G-code program follow a surface: Z + height(X, Y).
///
/// Every move below the safe height is levelled, at its ends and between them: lines and arcs
/// (which become helices) are cut into as few pieces as keep to height_tolerance; one that passes
/// the safe height is cut there first, and above it stays as it is. Modal words that the program
/// relies on and does not state (G17, G90, G91.1, G94, G98, its unit) are written before the first
/// move or feed that depends on them, with a remark. Rapid moves below it are no
/// exception. Steps (G91) lead to the surface and back. Drilling cycles get a Z and an R of their
/// own at every hole, R at most where the tool travels; before a series that begins below the safe
/// height the tool goes there, so that G98 returns to R. A move from above the safe height to a
/// board below 0, or back, keeps to its way down to the safe height. Everything else, comments and
/// feeds too, stays as written. Over a void the predicted height holds, as a tool cuts across what
/// was drilled before; from one zone to another it goes where both have one height. A move whose
/// place is not known, or lies where the map does not reach, is refused: the tool would go through
/// the board, or through the table.
///
/// Fails  as read_gcode_block() and MotionReader; coordinate-missing: a move below the safe height
///        from or to an unknown place; grid-invalid: the map does not reach; argument-invalid: a
///        safe height that the board reaches, none at all, a tolerance of 0 or less, a map
///        whose 0 is not on the board, a step between zones
/// See    tests/program/gcode/leveller_test.cc
Expected<LevelledGcode> level_gcode(const SourceText& program,
                                    const ZonedMap& map,
                                    const LevelOptions& options = {});

}  // namespace panelcal
