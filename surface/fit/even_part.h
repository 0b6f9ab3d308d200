// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "surface/fit/probe_point.h"

// Not installed: part of surface/fit/fit.h and surface/fit/outliers.h.
namespace panelcal::internal {

/// Some of many probes, in their order, that show both how a surface bends all over the panel and
/// what it does over the shortest distance probed: half of them as far from each other as can be,
/// and the nearest of the others to each.
///
/// In     n: 2 or more, fewer than there are points
/// Cost   O(n) per point
/// Source Gonzalez 1985 (farthest first)
/// See    tests/surface/fit/even_part_test.cc
std::vector<ProbePoint> even_part(std::span<const ProbePoint> points, std::size_t n);

/// Indices of neighbours together, at most this number each: halves of halves, across the longer
/// side.
///
/// In     most: 1 or more
/// Cost   O(n log^2 n)
/// Source Bentley 1975 (k-d tree)
/// See    tests/surface/fit/even_part_test.cc
std::vector<std::vector<std::size_t>> neighborhoods(std::span<const ProbePoint> points,
                                                    std::size_t most);

}  // namespace panelcal::internal
