// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "program/walk/survey.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// The surface as all probes of a job show it, on one Z axis.
///
/// In     max_extrapolation: how far outside of the probes' hull it is still believed
///        axis: from 0
/// Fails  grid-invalid (fewer than kLeastForBow probes found it: a plane through them says nothing
///        of how the board bends between them; or as HeightMap::of_probes); measurement-invalid (a
///        probe that states no sigma)
/// See    tests/program/judge/depth_verdict_test.cc
Expected<ZonedMap> probed_surface(const Survey& survey,
                                  Length max_extrapolation,
                                  std::size_t axis = 0);

/// The same on every Z axis that probed; at least on the first.
std::vector<Expected<ZonedMap>> probed_surfaces(const Survey& survey, Length max_extrapolation);

}  // namespace panelcal
