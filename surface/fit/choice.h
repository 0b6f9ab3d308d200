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
/// keeps. The plane is taken if what it misses more, probe by probe, is within one standard error
/// of nothing, and the probes scatter about it as little as options.most_noise asks. A thin plate
/// must miss less than the process: it is no simpler, and what probes left out scatter themselves
/// hides how much worse its heights are. A probe that only one of two models predicts counts
/// against the other as the worst miss of either. A grid model is taken if the probes make a grid
/// and what that choice misses more is beyond one standard error: it believes every probe, so
/// something must speak for it.
///
/// Of more than kMostBentProbes only grid models are tried.
///
/// Fails  as fit_without_outliers()
/// Source Stone 1974 (cross-validation); Breiman et al. 1984, 3.4.3 (one standard error)
/// See    tests/surface/map/height_map_test.cc
Expected<ChosenSurface> choose_surface(std::span<const ProbePoint> points,
                                       const OutlierOptions& options = {});

}  // namespace panelcal
