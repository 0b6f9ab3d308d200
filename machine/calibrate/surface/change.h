// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "surface/map/difference.h"
#include "surface/map/file.h"
#include <Eigen/Core>

namespace panelcal {

/// The change of a table's surface from one map to a later one.
struct SurfaceChange {
  MapDifference difference;  ///< of what the maps vouch for
  Measured rms_mm;           ///< over the later map's probes
  /// Signed, of the greatest change anywhere: of the maps, or of a probe that the later map leaves
  /// out (a chip, a swarf).
  Measured greatest_mm;
  Eigen::Vector2d greatest_at_mm = Eigen::Vector2d::Zero();
  std::string greatest_probe;  ///< the probe that was left out; empty: it is of the maps
  /// Probes that the later map leaves out where the earlier one did as well: a chip that is known.
  /// They are held against the earlier one's reading.
  int n_known = 0;
};

/// Fails  as difference_of()
/// See    tests/machine/calibrate/surface/change_test.cc
Expected<SurfaceChange> change_between(const StoredMap& before, const StoredMap& after);

}  // namespace panelcal
