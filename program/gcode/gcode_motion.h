// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "panelcal/calib/base/expected.h"
#include "panelcal/program/gcode/gcode_block.h"

namespace panelcal::gcode {

enum class MotionKind : std::uint8_t { Rapid, Line, Clockwise, Counterclockwise, Cycle };

/// Where the tool stands in work coordinates, mm; absent where nobody knows.
struct Standing {
  std::optional<double> x_mm, y_mm, z_mm;

  bool has_xy() const { return x_mm && y_mm; }
  /// Precondition: has_xy().
  Eigen::Vector2d xy_mm() const { return {*x_mm, *y_mm}; }
};

/// A move of the tool.
struct Motion {
  MotionKind kind = MotionKind::Rapid;
  Standing from;
  Standing to;                                          ///< of a cycle: the hole's bottom
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< of an arc
  double sweep_rad = 0;                                 ///< of an arc, counter-clockwise positive
  double retract_mm = 0;                                ///< R of a cycle
  bool returns_to_r = false;                            ///< G99: a cycle ends at R

  bool is_arc() const {
    return kind == MotionKind::Clockwise || kind == MotionKind::Counterclockwise;
  }
};

/// Follows the modal state of a program of LinuxCNC's kind (RS274NGC), as far as moves need it.
///
/// Understood: G0 to G3 in the XY plane, G73, G81 to G83, G85, G86 and G89, G20, G21, G90, G98,
/// G99, arcs by I, J or R. Whatever makes coordinates mean something else in the middle of a
/// program is refused: a move counts for the board only if it is known where it goes.
///
/// Source NIST RS274NGC version 3 (2000), 3.5; LinuxCNC G-code reference
/// See    tests/program/gcode/gcode_motion_test.cc
class MotionReader {
 public:
  explicit MotionReader(std::string file) : file_(std::move(file)) {}

  /// The move of a block, if it makes one.
  ///
  /// Fails  not-supported; argument-invalid (no units yet, an arc that is none);
  ///        coordinate-missing
  Expected<std::optional<Motion>> read(const GcodeBlock& block);

  /// M2 or M30 was read: what follows is no program any more.
  bool has_ended() const { return has_ended_; }
  /// Millimetres of the unit that coordinates are in now.
  double unit_mm() const { return unit_mm_.value_or(1); }
  bool arcs_are_absolute() const { return arcs_are_absolute_; }

 private:
  Expected<void> read_modes(const GcodeBlock& block);
  Expected<void> read_mode(const GcodeBlock& block, const GcodeWord& word);
  Expected<Motion> read_motion(const GcodeBlock& block);
  Expected<void> read_arc(const GcodeBlock& block, Motion& motion) const;
  Expected<void> read_cycle(const GcodeBlock& block, Motion& motion);
  tl::unexpected<Diagnostic> problem(const GcodeBlock& block,
                                     Code code,
                                     const GcodeWord* word,
                                     std::string what,
                                     std::string expected) const;
  std::optional<double> number_mm(const GcodeBlock& block, char letter) const;

  std::string file_;
  std::optional<double> unit_mm_;
  std::optional<double> motion_ = std::nullopt;  ///< the modal G number; absent: none or G80
  bool is_incremental_ = false;
  bool arcs_are_absolute_ = false;
  bool returns_to_r_ = false;
  bool has_moved_ = false;
  bool has_ended_ = false;
  bool leaves_ = false;  ///< G28, G30 or G53 in this block: nobody knows where it goes
  Standing at_;
  std::optional<double> cycle_z_mm_, cycle_r_mm_;
};

}  // namespace panelcal::gcode
