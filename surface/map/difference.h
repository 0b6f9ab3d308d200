// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "surface/map/file.h"
#include <Eigen/Core>

namespace panelcal {

/// Test of a part of a difference against chance.
struct DifferencePart {
  double chi_square = 0;
  int degrees_of_freedom = 0;
  double chance = 1;  ///< of as much or more if nothing had changed
};

/// A number and its standard deviation.
struct Measured {
  double value = 0;
  double sigma = 0;
};

/// The change from one map to another.
struct MapDifference {
  std::size_t n_probes = 0;   ///< of the later map, where the earlier one gives heights
  std::size_t n_outside = 0;  ///< its others
  /// Predicts the earlier map's probes: its own model, or a Gaussian process of them
  SurfaceModel model = SurfaceModel::GaussianProcess;
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< of these probes' rectangle
  Eigen::Vector2d half_mm = Eigen::Vector2d::Zero();    ///< half of its sides

  DifferencePart all;
  DifferencePart offset, tilt;        ///< each beyond those before it
  std::optional<DifferencePart> bow;  ///< empty: the probes do not tell it
  std::optional<DifferencePart> rest;

  Measured offset_um;                          ///< at the center, later minus earlier
  Measured tilt_x, tilt_y;                     ///< um by m
  std::optional<Measured> bow_x_um, bow_y_um;  ///< ends of the rectangle above its middle
  std::optional<Measured> twist_um;            ///< two opposite corners above it, the others below

  /// Corners of what both maps probed, counter-clockwise; and over it
  std::vector<Eigen::Vector2d> common_mm;
  Length rms;
  Length greatest;        ///< signed
  Length greatest_sigma;  ///< of it, as if the maps' errors were independent
  Position<frame::Nominal> greatest_at;
};

/// The surface that predicts another map's probes, with correlated errors: a map's own surface;
/// of a grid model, which has no such covariance, a Gaussian process of the map's probes, or of
/// an even part if these are more than kMostBentProbes.
///
/// Fails  as fit_surface()
Expected<SurfaceFit> predictor_of(const StoredMap& stored);

/// Compares the later map's probes with what the earlier map predicts of them.
///
///   d_i = height_i - before(place_i),   cov = C_before(place_i, place_j) + k^2 sigma_i^2 [i = j]
///
/// Readings and map err independently, so this needs nothing of how the later map fills its gaps.
/// Offset, tilt, bow and twist are generalized least squares; what each takes from chi square,
/// beyond those before it, is judged by an F distribution, for the probes' scatter is known only as
/// well as the maps know it.
///
/// Fails  grid-invalid: fewer than 3 later probes, or all in one line, where the earlier map gives
///        heights; nothing that both maps probed; as fit_surface(), for a grid's probes
/// Source Bjorck 1996 (generalized least squares); Rasmussen and Williams 2006, 2.2
/// See    tests/surface/map/difference_test.cc
Expected<MapDifference> difference_of(const StoredMap& before, const StoredMap& after);

}  // namespace panelcal
