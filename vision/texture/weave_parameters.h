// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// The glass weave of the laminate: fixed to the panel, so that overlapping pictures agree.
struct Weave {
  double amplitude = 0;                                          ///< of full scale
  Length period = mm(0.5);                                       ///< from yarn to yarn but one
  std::uint64_t seed = 1;                                        ///< of the yarns' irregularity
  Transform<frame::Nominal, frame::Optical> panel_from_optical;  ///< the place of the picture
};

}  // namespace panelcal
