// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/geometry/bounding_box.h"
#include "program/text/source_text.h"
#include <Eigen/Core>

namespace panelcal {

/// The places of a board in the coordinates that the machine is told.
class BoardPlaces {
 public:
  virtual ~BoardPlaces() = default;

  /// Smooth at the scale of 2 mm, and defined all over the plane.
  virtual Eigen::Vector2d actual_mm(const Eigen::Vector2d& nominal_mm) const = 0;
  /// Standard deviation of that place in its worst direction. Asked where the tool works.
  ///
  /// Fails  with what keeps the machine from working there
  virtual Expected<Length> sigma(const Eigen::Vector2d& nominal_mm) const = 0;
};

struct MoveOptions {
  /// Lines and arcs of the written program are this near to the images of the program's. Smaller
  /// values make more pieces where arcs become ellipses.
  Length tolerance = um(2);
  /// The unit of coordinates before G20 and G21, mm; empty: such a program is refused.
  std::optional<double> unit_mm;
  /// Told the share of the program's bytes that is done, 0 to 1, now and then. May be empty.
  std::function<void(double)> progress;
};

struct MoveFigures {
  std::int64_t n_moves = 0;   ///< of X, Y or Z
  std::int64_t n_moved = 0;   ///< of these: in X or Y
  std::int64_t n_pieces = 0;  ///< that the moved ones have become
  std::int64_t n_left = 0;    ///< lines in the machine's coordinates (G53, G28, G30), as they were
  /// Of lines, arcs and holes, and of feeds down: not of ways between them.
  BoundingBox<frame::Nominal> nominal;
  BoundingBox<frame::Actual> actual;
  Length largest_shift;  ///< from nominal to actual
  Length largest_sigma;
  int line_of_largest_sigma = 0;
};

struct MovedGcode {
  std::string text;
  std::vector<int> source_lines;  ///< numbers of the lines that the text's lines were made of
  MoveFigures figures;
};

/// Makes a G-code program for a board as it lies: X and Y of every move become the actual place of
/// the nominal one. Z, feeds, tools, comments and all other words stay.
///
/// Both X and Y are written where either stood. Arcs stay arcs while their images are circles
/// within the tolerance, else they become arcs and lines; arcs by R get I and J. Steps (G91) lead
/// from actual place to actual place; subprograms are written out where they are called. G92 and
/// G52 stay as they are, and coordinates behind them count from where they put the zero. Modal
/// words that the program relies on and does not state are written, as in level_gcode().
///
/// Fails  as read_gcode_block(), ExecutedLines and MotionReader; coordinate-missing: X or Y of a
///        move is unknown, or Z of one that is cut; not-supported: variables in a subprogram, G92
///        or G52 beside other words; argument-invalid: a tolerance of 0 or less; what keeps the
///        machine from a place
/// See    tests/program/gcode/mover_test.cc
Expected<MovedGcode> move_gcode(const SourceText& program,
                                const BoardPlaces& places,
                                const MoveOptions& options = {});

}  // namespace panelcal
