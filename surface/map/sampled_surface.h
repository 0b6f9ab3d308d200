// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "surface/fit/fit.h"
#include "surface/map/height_lattice.h"
#include <Eigen/Core>

// Not installed: part of surface/map/height_map.h.
namespace panelcal::internal {

/// A surface on lattices. That of the heights is as fine as they need; sigma changes no faster than
/// the probes stand.
struct Sampled {
  HeightLattice heights;
  HeightLattice sigmas;
  double error_mm = 0;  ///< of the heights, at most
};

/// Samples a surface on lattices over a rectangle: refines until the lattice is good or has as many
/// nodes as it may have.
///
/// In     spacing_mm: of the probes
/// Fails  as HeightLattice::make()
/// See    tests/surface/map/height_map_test.cc
Expected<Sampled> sample_finely(const SurfaceFit& surface,
                                const Eigen::Vector2d& low_mm,
                                const Eigen::Vector2d& high_mm,
                                double spacing_mm,
                                LatticeInterpolation interpolation);

}  // namespace panelcal::internal
