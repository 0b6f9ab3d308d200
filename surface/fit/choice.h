// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "calib/base/expected.h"
#include "surface/fit/outliers.h"

namespace panelcal {

/// A surface and why it is of this model.
struct ChosenSurface {
  SoundSurface surface;
  std::string reason;
};

/// Chooses between a plane and a Gaussian process, which is fitted first, to the probes that it
/// keeps.
///
/// The plane is taken if scatter may be all that it misses (of stated scatter by chance, of an
/// assumed one up to twice as much), and if what it misses more than the process, probe by probe,
/// is within one standard error of nothing. A probe that only one of them predicts counts against
/// the other as the worst miss of either. Six to twelve probes never take it, as a bend of the size
/// of their scatter escapes them.
///
/// The reason says what a thin plate and, if the probes make a grid, grid models miss as well; none
/// of them is taken, for their sigma knows no other shape.
///
/// Of more than kMostBentProbes only grid models are tried.
///
/// Fails  as fit_without_outliers()
/// Source Stone 1974 (cross-validation); Breiman et al. 1984, 3.4.3 (one standard error)
/// See    tests/surface/map/height_map_test.cc
Expected<ChosenSurface> choose_surface(std::span<const ProbePoint> points,
                                       const OutlierOptions& options = {});

}  // namespace panelcal
