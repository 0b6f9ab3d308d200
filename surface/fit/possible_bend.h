// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/probe_point.h"
#include <Eigen/Core>

namespace panelcal {

/// Up to this number of probes no clean part judges the rest: each is judged by all the others.
inline constexpr std::size_t kFewProbes = 15;

/// Of the distance to the fourth nearest place: a bend that reaches that far is the same here.
inline constexpr double kSameProbePlace = 0.1;

/// A bend of the board that a probe may show which was left out as wild.
///
///   error(p) = height exp(-|p - place|^2 / (2 reach^2))
///
/// One standard deviation: few probes tell neither that the board bends there nor that it does not.
struct PossibleBend {
  Position<frame::Nominal> place;
  Length height;  ///< by which the probe is off the others' prediction
  Length reach;

  /// Error that the surface has at these places if the board bends, mm.
  Eigen::VectorXd errors_mm(std::span<const Position<frame::Nominal>> places) const;
};

/// The bend that a probe may show: no probe tells how far it reaches but the kept ones around it,
/// and as the pitch of columns may be another than that of rows, it ends at the fourth nearest
/// place. Probes nearer to each other than kSameProbePlace of the way there are of one place.
/// Empty where a kept probe is of the wild one's place: it tells the height there.
///
/// In     kept: 1 or more
std::optional<PossibleBend> possible_bend(const ProbePoint& wild,
                                          Length deviation,
                                          std::span<const ProbePoint> kept);

}  // namespace panelcal
