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

/// Chooses the model that predicts probes best that were left out.
///
/// Plane, thin plate and Gaussian process are fitted to the probes that the most flexible of them
/// keeps. The plane is taken if scatter may be all that it misses (of stated scatter by chance, of
/// an assumed one up to twice as much), and if what it misses more than the process, probe by probe,
/// is within one standard error of nothing. A thin plate and grid models, whose sigma knows no other
/// shape, are taken only if the process misses more than they beyond one standard error; a grid model
/// if the probes make a grid. A probe that only one of two models predicts counts against the other as
/// the worst miss of either.
///
/// Of more than kMostBentProbes only grid models are tried.
///
/// Fails  as fit_without_outliers()
/// Source Stone 1974 (cross-validation); Breiman et al. 1984, 3.4.3 (one standard error)
/// See    tests/surface/map/height_map_test.cc
Expected<ChosenSurface> choose_surface(std::span<const ProbePoint> points,
                                       const OutlierOptions& options = {});

}  // namespace panelcal
