// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "surface/fit/bending/bending_likelihood.h"
#include "surface/fit/probe_point.h"
#include "surface/fit/shape.h"
#include <Eigen/Core>

// Not installed: part of surface/fit/fit.h.
namespace panelcal::internal {

/// Precondition: points is not empty, all numbers are finite
Readings readings_of(std::span<const ProbePoint> points);

/// A bending of readings in mm. A noise factor above 1 of readings whose scatter is stated becomes
/// unresolved bending.
SurfaceShape shape_of(const Bending& bending, const Readings& readings, Eigen::Index n_trend);
Bending bending_of(const SurfaceShape& shape, const Readings& readings);

}  // namespace panelcal::internal
