// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/faults/constellation.h"

namespace panelcal::test {

enum class Neighbours : std::uint8_t {
  Alike,      ///< every target stands in the same row of equal pads
  Different,  ///< no shift but none is common to the rows of all targets
};

/// Model of a camera that sees boards, at the level of candidates.
struct BoardTrial {
  double min_view_mm = 11.5;  ///< half the width of the view
  double max_view_mm = 15;
  double covered = 0.01;  ///< chance that a pad does not count, but leaves a trace
  double lost = 1e-4;     ///< chance that a pad leaves no trace
  double spurious = 0.5;  ///< mean number of other things in a view, one of five counts
};

/// A board in front of a camera: what its pictures list, and which candidates are the targets.
struct SimulatedBoard {
  std::vector<ConstellationTarget> targets;
  std::vector<int> right;  ///< index of the target's own candidate; -1: not listed
  ConstellationOptions options;
  double pitch_mm = 0;
};

/// Two to four targets, each in a row (one row or two) of equal pads at 1.27 to 2.54 mm, on a panel
/// that is shifted by up to three pitches, turned and stretched.
SimulatedBoard simulated_board(Random& random, Neighbours neighbours, const BoardTrial& trial = {});

/// A released assignment that has a wrong pad.
bool is_wrong(const SimulatedBoard& board, const Constellation& found);

}  // namespace panelcal::test
