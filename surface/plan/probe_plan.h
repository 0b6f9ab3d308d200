// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/probe_point.h"
#include "surface/fit/shape.h"
#include "surface/plan/request.h"

namespace panelcal {

/// Greatest sigma of a map, and its place.
struct WorstSigma {
  Length sigma;
  Position<frame::Nominal> at;
};

/// A regular grid that does as well.
struct RegularGrid {
  int n_columns = 0, n_rows = 0;
  WorstSigma worst;

  int n_probes() const { return n_columns * n_rows; }
};

struct ProbePlan {
  bool is_reached = false;
  std::string why_not;                           ///< if it is not
  std::vector<Position<frame::Nominal>> probes;  ///< in a short order to visit them
  Length way;                                    ///< from the first to the last
  WorstSigma worst;                              ///< with them
  std::optional<WorstSigma> before;  ///< with the present ones; empty: they tell nothing
  std::size_t n_pruned = 0;          ///< taken at first, and found not to be needed
  std::optional<RegularGrid> grid;   ///< the smallest; empty: none of kMostPlanned does
};

/// Chooses the fewest places that it finds whose probes make a map sure enough.
///
/// The search begins greedily, or with a regular grid if that has fewer; it drops what is not
/// needed, and then goes on to drop one and to move the others until the tolerance holds again. How
/// much a probe takes from each variance is exact, for it does not depend on what is found. Sigmas
/// are those of fit_surface() of the shape, so what is planned is what the map will say, if the
/// panel bends as it is believed to.
///
/// The fewest of all sets of candidates is not found for certain: that is NP-hard.
///
/// In     places: 1 or more; of more than some thousand, those that are unsure are found by turns
/// Out    is_reached = false: a tolerance below the probe's own sigma, which only probes could
/// bring
///        about that err independently, and that no map can know; or all candidates do not reach it
/// Fails  config-value: numbers that make no request; kMostPlanned probes that are there and not
/// enough Cost   for n probes, q candidates and m places O(n q (m + q)) Source Krause, McMahan,
/// Guestrin and Gupta 2008 (truncated sums); Rasmussen and Williams 2006, 2.7 See
/// tests/surface/plan/probe_plan_test.cc
Expected<ProbePlan> plan_probes(const ProbePlanRequest& request);

}  // namespace panelcal
