// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

// Not installed.
namespace panelcal::internal {

/// Up to this number of places a path is certainly the shortest.
inline constexpr std::size_t kMostExactPath = 12;

/// The costs of an order of n places: `between` of all that follow each other, and `around` of the
/// last and the first, which holds what leads to the path, what follows it, and what joins its
/// repetitions.
struct PathCosts {
  Eigen::MatrixXd between;  ///< n x n, symmetric
  Eigen::MatrixXd around;   ///< n x n: row the last place, column the first

  std::size_t size() const { return static_cast<std::size_t>(between.rows()); }
  /// In     order: each place once, or empty
  double of(const std::vector<std::size_t>& order) const;
};

/// A cheap order of all places, never dearer than the given one.
///
/// Exact up to kMostExactPath, by dynamic programming (Held and Karp 1962). Beyond, a local optimum
/// under 2-opt and or-opt moves (Croes 1958; Or 1976) that random double bridges do not improve
/// (Martin, Otto and Felten 1991; the same bridges each time), fewer of them the more places.
///
/// In     order: each place once
/// Cost   some 20 ms up to 12 places, some 0.5 s for 200
/// See    tests/calib/advice/short_path_test.cc
std::vector<std::size_t> short_path(const PathCosts& costs, std::vector<std::size_t> order);

}  // namespace panelcal::internal
