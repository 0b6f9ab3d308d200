// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/expected.h"
#include "program/gcode/block.h"
#include <Eigen/Core>

namespace panelcal::gcode {

enum class MotionKind : std::uint8_t { Rapid, Line, Clockwise, Counterclockwise, Cycle };

/// Place of the tool in work coordinates, mm; absent where unknown.
struct Standing {
  std::optional<double> x_mm, y_mm, z_mm;

  bool has_xy() const { return x_mm && y_mm; }
  /// Precondition: has_xy().
  Eigen::Vector2d xy_mm() const { return {*x_mm, *y_mm}; }
};

/// The unit of coordinates, and their zero.
struct Counting {
  double unit_mm = 1;
  bool is_incremental = false;  ///< G91: from where the tool is
};

/// A move of the tool.
struct Motion {
  MotionKind kind = MotionKind::Rapid;
  Standing from;
  Standing to;                                          ///< of a cycle: the hole's bottom
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< of an arc
  double sweep_rad = 0;                                 ///< of an arc, counter-clockwise positive
  double retract_mm = 0;                                ///< R of a cycle
  double travel_mm = 0;  ///< Z at which a cycle moves on: R, or with G98 where it began if higher

  bool is_arc() const {
    return kind == MotionKind::Clockwise || kind == MotionKind::Counterclockwise;
  }
  /// In X or Y, as far as that is known.
  bool goes() const { return from.x_mm != to.x_mm || from.y_mm != to.y_mm || is_arc(); }
};

/// Place of a move at a part of its way, 0 to 1.
///
/// Precondition: it is known where it begins and ends; the same for its length.
Eigen::Vector2d place_mm(const Motion& motion, double part);
double length_mm(const Motion& motion);  ///< in X and Y

/// Follows the modal state of a program of LinuxCNC's kind (RS274NGC), as far as moves need it.
///
/// Understood: G0 to G3 in the XY plane, G73, G81 to G83, G85, G86 and G89, G20, G21, G90, G91,
/// G98, G99, arcs by I, J or R. Whatever makes coordinates mean something else in the middle of a
/// program is refused (also M70 to M73, which restore modes, and the user's own M100 to M199): a
/// move counts for the board only if it is known where it goes. Behind a change of tool and a way
/// home (M6, G28, G30) the place of the tool is unknown, behind a move in the machine's coordinates
/// (G53) that of the axes that moved, and also behind a step from there. In G91 R of a cycle is a
/// step from where the tool is, and Z one from R; the next holes keep both heights.
///
/// Source NIST RS274NGC version 3 (2000), 3.5; LinuxCNC G-code reference
/// See    tests/program/gcode/motion_test.cc
class MotionReader {
 public:
  /// In     unit_mm: what coordinates count in before G20 and G21; empty: such moves are refused
  explicit MotionReader(std::string file, std::optional<double> unit_mm = std::nullopt)
      : file_(std::move(file)), unit_mm_(unit_mm) {}

  /// The move of a block, if it makes one.
  ///
  /// Fails  not-supported; argument-invalid (no units yet, an arc that is not valid);
  ///        coordinate-missing
  Expected<std::optional<Motion>> read(const GcodeBlock& block);

  /// Modal words on which a block depends and which the program has not stated, as they are taken
  /// here: "G17 G91.1". A control has what the program before it has left, which for a cycle may be
  /// G99: the way to the next hole is then at R, through what stands higher there. A feed (F)
  /// counts in the unit that is in force where it stands. The words count as stated from now on,
  /// since the caller writes them.
  ///
  /// In     block, motion: the last read
  std::string take_unstated(const GcodeBlock& block, const std::optional<Motion>& motion);
  /// M2 or M30 was read: nothing follows that moves.
  bool has_ended() const { return has_ended_; }
  /// The unit of coordinates now.
  Counting counting() const { return {unit_mm(), is_incremental_}; }
  bool arcs_are_absolute() const { return arcs_are_absolute_; }
  bool has_unit() const { return unit_mm_.has_value(); }
  /// The place of the tool now.
  const Standing& standing() const { return at_; }
  /// Counts that place anew: the zero was shifted.
  void stand_at(const Standing& at) { at_ = at; }
  /// The last block went to a place that the program does not state (G28, G30, G53).
  bool has_left() const { return leaves_; }

 private:
  /// Modes that the program has set.
  struct Stated {
    bool plane = false, unit = false, distance = false, arcs = false, feed = false, retract = false;
  };

  void note(double code);
  Expected<void> read_modes(const GcodeBlock& block);
  Expected<void> read_code(const GcodeBlock& block, const GcodeWord& word);
  Expected<void> read_function(const GcodeBlock& block, const GcodeWord& word);
  Expected<void> leave(const GcodeBlock& block, const GcodeWord& word);
  Expected<Motion> read_motion(const GcodeBlock& block);
  double unit_mm() const { return unit_mm_.value_or(1); }
  void forget(const GcodeBlock& block);
  void read_axis(const GcodeBlock& block, char letter, std::optional<double>& at_mm) const;
  Expected<void> read_arc(const GcodeBlock& block, Motion& motion) const;
  Expected<Eigen::Vector2d> center_mm(const GcodeBlock& block, const Motion& motion) const;
  Expected<void> read_cycle(const GcodeBlock& block, Motion& motion);
  tl::unexpected<Diagnostic> problem(const GcodeBlock& block,
                                     Code code,
                                     const GcodeWord* word,
                                     std::string what,
                                     std::string expected) const;
  std::optional<double> number_mm(const GcodeBlock& block, char letter) const;

  std::string file_;
  std::optional<double> unit_mm_;
  std::optional<MotionKind> motion_;  ///< the modal one; absent: none yet, or G80
  double cycle_code_ = 0;             ///< of a cycle: what Z and R belong to
  double offset_code_ = 54;           ///< code of the work zero in force
  bool is_incremental_ = false;
  bool arcs_are_absolute_ = false;
  bool returns_to_r_ = false;
  Stated stated_;
  bool has_moved_ = false;
  bool has_ended_ = false;
  bool leaves_ = false;  ///< this block goes to an unknown place
  Standing at_;
  std::optional<double> cycle_z_mm_, cycle_r_mm_;  ///< absolute
  std::optional<double> cycle_began_mm_;           ///< Z before the first of a series of cycles
};

}  // namespace panelcal::gcode
