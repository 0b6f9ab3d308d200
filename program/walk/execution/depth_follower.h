// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/model/board_depths.h"
#include "program/model/operation.h"
#include "program/walk/reporter.h"

namespace panelcal {

/// Gives depths below the board's surface the height that they count from, and tools the depth that
/// [[depth]] states.
///
/// A height that the program probed by itself stays. A place that the map does not reach, or where
/// it is less sure than [surface] max_sigma_um, refuses the job: a wrong depth is worse than none.
/// Each kind of problem is reported once: all that follow would say the same.
///
/// Fails  into the reporter: grid-invalid (the map does not reach a place); tolerance-hold (it is
///        not sure enough there); argument-invalid (program and [[depth]] contradict each other; a
///        stroke below the plane that limits it; a way that bends too much, or
///        over a step from zone to zone)
/// See    tests/program/walk/execution/depth_follower_test.cc
class DepthFollower {
 public:
  /// Precondition: both outlive this
  DepthFollower(const BoardDepths& board, const Reporter& reporter)
      : board_(board), reporter_(reporter) {}

  /// False: at() changes nothing.
  bool is_needed() const { return board_.map != nullptr || tool_depth_.has_value(); }
  /// [[depth]] says how deep the tool in use works.
  bool has_tool_depth() const { return tool_depth_.has_value(); }

  void take(int line, const Tool& tool);
  /// Holes come in strokes whose upper turning point counts from the table or the board, as the
  /// program has it: [[depth]] must not have them count from the other one.
  /// Source SIEB & MEYER CNC 8x.00 Command Set, G81, G89 (I)
  void set_pecking(bool pecks) { pecks_ = pecks; }
  /// The cut of a tool at a place for this order.
  DepthOfCut at(int line, const Position<frame::Nominal>& place, const DepthOfCut& asked);
  /// Its height at every place is the map's.
  bool follows_map(const DepthOfCut& asked) const {
    return board_.map != nullptr && (asked.depth || tool_depth_) && !asked.surface;
  }
  /// The shares of a way at which it is cut into as few pieces as keep to height_tolerance if the
  /// tool goes evenly from one to the next; the last is 1.
  ///
  /// In     place: by the share of the way that is done
  std::vector<double> cuts(int line,
                           const std::function<Position<frame::Nominal>(double share)>& place,
                           double length_mm);

 private:
  void take_height(int line, const Position<frame::Nominal>& place, DepthOfCut& cut);
  void refuse_step(int line,
                   const Position<frame::Nominal>& from,
                   const Position<frame::Nominal>& to);
  void refuse(Code code, int line, std::string what, std::string expected);
  /// Once for the tool in use.
  std::optional<Diagnostic> contradiction(int line, const std::string& said);
  void refuse_at(int line, const std::string& said);

  const BoardDepths& board_;
  const Reporter& reporter_;
  int tool_ = 0;
  std::optional<Length> tool_depth_;
  bool has_refused_place_ = false;
  bool has_refused_tool_ = false;  ///< the one in use
  bool pecks_ = false;
};

}  // namespace panelcal
