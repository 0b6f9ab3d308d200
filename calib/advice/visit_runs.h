// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/base/frames.h"

namespace panelcal {

/// Places that follow each other, of which only the inner order is free, and the same for all runs
/// of a kind: the targets of a series, in every copy of its pattern.
struct VisitRun {
  std::size_t kind = 0;
  std::vector<std::size_t> places;  ///< equally many in all runs of a kind
};

/// The order of visits if every kind has its best inner order and the runs stay as they are.
///
/// One kind after the other gets its best order until none changes: the shortest of all for up to
/// 12 places, one found by search for more (short_path.h).
std::vector<std::size_t> order_within_runs(std::span<const Position<frame::Nominal>> places,
                                           std::span<const VisitRun> runs);

}  // namespace panelcal
