// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "machine/calibrate/surface/figures.h"
#include "machine/config/settings/nightly_options.h"
#include "program/walk/probing.h"
#include "surface/map/file.h"
#include <Eigen/Core>

namespace panelcal {

/// The table's surface as it was probed. Nothing is installed.
struct SurfaceRun {
  StoredMap stored;
  SurfaceFigures figures;
  /// Places where nothing was touched, and why.
  std::vector<std::string> missed;
  /// Of a reading, by the readings of each place; no degrees of freedom with one each.
  double reading_variance_mm2 = 0;
  int degrees_of_freedom = 0;
};

/// Probes the places of [nightly.surface] row by row, to and fro, and maps what it touches: a
/// Gaussian process every night, so that no night differs from the next by its model.
///
/// Readings of a place are averaged. Those that do not fit the map are left out of it, by name.
///
/// In     surface: complete; made_by: "panelcal 0.1.0"
/// Fails  calibration-data: too few places were touched, or they make no surface; what the probe
///        reports
/// See    tests/machine/calibrate/kinds/surface_night_test.cc
Expected<SurfaceRun> probe_surface(const NightSurface& surface,
                                   ProbeSource& probe,
                                   const std::string& made_by);

/// The places that a night probes, row by row, to and fro: machine coordinates, mm.
std::vector<Eigen::Vector2d> probed_places_mm(const NightSurface& surface);

/// The area of [nightly.surface].
SurfaceArea area_of(const NightSurface& surface);

/// In lines: places, the map, what was left out or not touched, the figures.
std::string report(const SurfaceRun& run);

}  // namespace panelcal
