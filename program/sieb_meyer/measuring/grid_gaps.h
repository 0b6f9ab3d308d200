// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "program/walk/survey.h"
#include "surface/control/grid_map.h"
#include <Eigen/Core>

namespace panelcal::sieb_meyer {

/// Nodes of the points' lattice that have no point, row by row.
std::vector<Eigen::Vector2d> missing_nodes(std::span<const GridPoint> points);

/// The prediction of the points at these nodes, on every Z axis by a map of its own, with the sigma
/// that such a height has.
///
/// In     max_extrapolation: how far outside of the points' hull a node may lie
/// Fails  grid-invalid: fewer than kLeastForBow points: a plane through them says nothing of how
/// the
///        board bends between them; a node farther outside; as HeightMap::of_probes. The places of
///        diagnostics are empty
/// See    tests/program/sieb_meyer/measuring/grid_gaps_test.cc
Expected<std::vector<FilledNode>> fill_nodes(std::span<const GridPoint> points,
                                             std::span<const Eigen::Vector2d> nodes_mm,
                                             Length max_extrapolation);

}  // namespace panelcal::sieb_meyer
