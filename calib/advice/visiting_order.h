// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// Length of the way from place to place in this order, from the first to the last.
Length way_length(std::span<const Position<frame::Nominal>> places,
                  std::span<const std::size_t> order);

/// Up to this number of places the order is certainly the best.
inline constexpr std::size_t kMostExact = 12;

/// Up to this number of places of a phase, and to this number in all, the search goes on beyond a
/// local optimum.
inline constexpr std::size_t kMostSearched = 200;
inline constexpr std::size_t kMostSearchedInAll = 500;

/// A short order to visit all places, those of a lower phase before those of a higher one.
///
/// Start and end are free. Exact up to kMostExact places, by dynamic programming (Held and Karp
/// 1962). Beyond, the better of two local optima under 2-opt and or-opt moves between near
/// neighbours (Croes 1958; Or 1976), one begun with the given order, the other with the nearest
/// neighbour each time; so it is never longer than the given order if that keeps to the phases.
/// Of up to kMostSearchedInAll places each phase of up to kMostSearched is then searched on its
/// own (short_path.h). Moves of more than 1,000 places are not tried where there are more than
/// 20,000.
///
/// In     phases: one per place
/// Out    indices into places
/// Cost   O(n log n) or so: some 3 s for 100,000 places
/// See    tests/calib/advice/visiting_order_test.cc
std::vector<std::size_t> short_order(std::span<const Position<frame::Nominal>> places,
                                     std::span<const int> phases);

}  // namespace panelcal
