// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/units.h"
#include "program/model/operation.h"
#include "program/writers/gcode/flavour.h"

namespace panelcal {

/// Motions of a tool, as far as the program leaves it to the machine. All Z are of the tool's tip,
/// as the words of the G-code program have them.
struct GcodeWork {
  std::optional<Length> drill_z;      ///< of holes; a depth offset of the tool comes to it
  std::optional<Length> rout_z;       ///< of contours; the same
  std::optional<Length> peck;         ///< a stroke, where the program asks for peck drilling
  std::optional<Feed> infeed;         ///< down into the board
  std::optional<Feed> retract;        ///< out of it; absent: a rapid move
  std::optional<Feed> feed;           ///< along a contour
  std::optional<SpindleSpeed> speed;  ///< clockwise

  friend bool operator==(const GcodeWork&, const GcodeWork&) = default;
};

/// Motions of one tool, or of all tools of one diameter.
struct GcodeTool {
  std::optional<int> number;
  std::optional<Length> drill;  ///< without a number: the diameter of the tools that are meant
  GcodeWork work;
};

/// [gcode]: what a G-code program has to know of the machine besides the part program.
struct GcodeSetting {
  std::optional<GcodeFlavour> flavour;  ///< absent: that of the machine's control, or LinuxCNC
  Length safe_z;                        ///< nothing is in the way at or above it
  /// Down to here the tool moves rapidly; absent: it feeds from safe_z on.
  std::optional<Length> approach_z;
  /// Height at which the tool waits while it is changed, at stops and at the end; absent: safe_z.
  std::optional<Length> change_z;
  std::optional<Length> table_z;  ///< the table plane, which the program's Z planes count from
  /// The board's surface, for depths below a surface that was not measured.
  std::optional<Length> board_z;
  std::optional<Time> spin_up;     ///< waited behind the start of the spindle
  std::optional<Feed> rapid;       ///< of rapid moves, where the flavour needs a feed for them
  bool has_length_offset = false;  ///< G43 behind a change of tool
  GcodeWork usual;                 ///< of all tools that no row says more of
  std::vector<GcodeTool> tools;    ///< rows with a number go before those with a diameter

  /// The data of a tool; the program's own rates and speed win.
  ///
  /// See    tests/program/writers/gcode/setting_test.cc
  GcodeWork work_of(const Tool& tool) const;
};

}  // namespace panelcal
