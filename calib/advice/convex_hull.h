// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// The convex hull of places: its corners counter-clockwise, without those on a side. Places in one
/// line have two corners, a single place one.
///
/// Source Andrew 1979 (monotone chain)
/// See    tests/calib/advice/convex_hull_test.cc
std::vector<Position<frame::Nominal>> convex_hull(std::span<const Position<frame::Nominal>> places);

/// Distance of `p` from the hull that these corners make; zero inside. Precondition: not empty.
Length distance_outside(std::span<const Position<frame::Nominal>> corners,
                        const Position<frame::Nominal>& p);

/// The corners of very many places, in constant memory.
///
/// Beyond kMost corners only the outermost places in kMost directions are kept; a place that is
/// lost then lies within tan(pi / kMost) / 2 of the diameter of those that are kept: 0.3 mm on
/// 200 mm.
class HullBuilder {
 public:
  static constexpr std::size_t kMost = 1024;

  void add(const Position<frame::Nominal>& p) {
    if (waiting_.size() >= kFull) shrink();
    waiting_.push_back(p);
  }
  std::vector<Position<frame::Nominal>> corners() const;

 private:
  static constexpr std::size_t kFull = 4 * kMost;
  void shrink();

  std::vector<Position<frame::Nominal>> waiting_;
};

}  // namespace panelcal
