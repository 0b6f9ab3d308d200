// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/choice.h"
#include "surface/fit/fit.h"
#include "surface/fit/outliers.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_lattice.h"
#include <Eigen/Core>

namespace panelcal {

/// Source of a height.
enum class HeightSource : std::uint8_t {
  Measured,      ///< a probe stands as near as probes do here
  Filled,        ///< between probes, but where one is missing or was left out
  Extrapolated,  ///< outside of the probes' hull
  InVoid,  ///< in a hole or the like (surface/map/zoned_map.h): predicted, but nothing is there
};

/// A height of a map.
struct HeightAt {
  Length height;
  Length sigma;
  HeightSource source = HeightSource::Measured;
  Length outside;  ///< of the probes' hull; 0 inside
};

struct HeightMapOptions {
  /// Empty: what predicts left-out probes best.
  std::optional<SurfaceModel> model = std::nullopt;
  LatticeInterpolation interpolation = LatticeInterpolation::MonotoneBicubic;
  /// Farther outside of the probes' hull a height is refused. At most 1000 mm.
  Length max_extrapolation = mm(5);
  /// Reach to which a probe vouches for its surroundings, along x and y. Empty: half of the median
  /// distance of neighbouring columns, and of rows, if the probes stand in columns and rows but for
  /// a fifth of the distance of neighbouring probes; else 3/4 of the median distance to a probe's
  /// nearest neighbour, both ways.
  std::optional<Eigen::Vector2d> reach_mm = std::nullopt;
  OutlierOptions outliers = {};
};

/// A map of a panel's height, made of probes, that knows how sure it is and where it was not
/// measured.
///
/// The probes that fit each other make a surface (surface/fit/outliers.h), whose height and
/// sigma are sampled on a lattice so fine that interpolation adds less than a tenth to sigma, or as
/// much as lattice_error() says; both are then fast. A value: copies share what was made.
///
/// See    tests/surface/map/height_map_test.cc, height_map_slow_test.cc
class HeightMap {
 public:
  /// Fails  as fit_without_outliers(); config-value: an option outside its range; grid-invalid:
  ///        the probes that fit each other lie in one line but for some um
  static Expected<HeightMap> of_probes(std::span<const ProbePoint> points,
                                       const HeightMapOptions& options = {});

  /// The same of a surface that was chosen before, from these points.
  ///
  /// Precondition: chosen.surface.kept are indices into points
  static Expected<HeightMap> of_surface(std::span<const ProbePoint> points,
                                        ChosenSurface chosen,
                                        const HeightMapOptions& options);

  /// Fails  grid-invalid: farther outside than max_extrapolation; a number that is not finite
  Expected<HeightAt> height_at(const Position<frame::Nominal>& place) const;

  /// The heights alone, of many places, mm: some nanoseconds each inside of the hull. Filled and
  /// extrapolated ones are among them.
  ///
  /// In     heights_mm: one for each place
  ///        sources: empty, or one for each place, to be told where its height comes from; that
  ///        takes as long as height_at()
  /// Fails  as height_at(), for the first such place, and for spans of other sizes; heights_mm and
  ///        sources are then not to be used
  Expected<void> heights_at(std::span<const Eigen::Vector2d> places_mm,
                            std::span<double> heights_mm,
                            std::span<HeightSource> sources = {}) const;

  const SurfaceFit& surface() const;
  std::span<const SurfaceOutlier> outliers() const;
  /// Indices of the probes that make the surface, rising.
  std::span<const std::size_t> kept() const;
  /// Corners of these probes' convex hull, counter-clockwise.
  std::span<const Position<frame::Nominal>> hull() const;
  /// As given, and how far a probe vouches for its surroundings where that was not.
  HeightMapOptions options() const;
  /// The reason for this model, in words.
  const std::string& reason() const;
  const HeightLattice& lattice() const;
  /// The worst difference of lattice and surface where it was tried, in the middle of cells and
  /// about it; it is part of every sigma.
  Length lattice_error() const;

 private:
  struct State;
  explicit HeightMap(std::shared_ptr<const State> state) : state_(std::move(state)) {}

  std::shared_ptr<const State> state_;
};

}  // namespace panelcal
