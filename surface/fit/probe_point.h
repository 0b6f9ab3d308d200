// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/control/reference_plane.h"

namespace panelcal {

/// A height that was probed at a nominal place, for maps of a surface.
struct ProbePoint {
  Position<frame::Nominal> place;
  HeightEstimate measured;  ///< above the table plane; sigma is what the probe is said to scatter
  std::string name;         ///< for messages; may be empty
  Place from;               ///< place of the reading in a file, for messages
  /// The scatter is no measured one: fits learn it from the residuals too. Of stated ones a misfit
  /// is bending, and never the probe's scatter.
  bool is_sigma_assumed = false;
};

}  // namespace panelcal
