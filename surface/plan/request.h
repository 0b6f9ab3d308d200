// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/probe_point.h"
#include "surface/fit/shape.h"

namespace panelcal {

/// Larger plans are not looked for: the search takes as long as the cube of what is probed (600: a
/// minute).
inline constexpr std::size_t kMostPlanned = 600;

/// The prior of a panel before it is probed, and the tolerance of its map.
struct ProbePlanRequest {
  SurfaceModel model = SurfaceModel::GaussianProcess;  ///< a plane, or this
  BendingKernel kernel = BendingKernel::Matern52;
  Length amplitude;  ///< standard deviation of the bending about the trend
  Length length;     ///< over which it changes
  int n_trend = kPlaneTrend;
  Length probe_sigma;                            ///< scatter of one probe
  Length tolerance;                              ///< the most that sigma may be at any of `places`
  std::vector<Position<frame::Nominal>> places;  ///< places whose heights matter
  std::vector<Position<frame::Nominal>> candidates;  ///< places that may be probed
  std::vector<ProbePoint> present;                   ///< probes that are there already
  /// Of places between the candidates; empty: all of them.
  std::function<bool(const Position<frame::Nominal>&)> may_probe = {};

  /// The same as fit_surface() has it, of probes that scatter what they say.
  SurfaceShape shape() const;
};

}  // namespace panelcal
