// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/left_out_probe.h"
#include "surface/fit/possible_bend.h"
#include "surface/fit/probe_point.h"
#include "surface/fit/shape.h"
#include <Eigen/Core>

namespace panelcal {

/// `plane`, `thin plate`, `Gaussian process`, `bilinear`, `monotone bicubic`.
std::string_view name_of(SurfaceModel model);

/// A surface of more probes than this learns its shape from this number of them:
/// the cost grows with the cube of their number (600: some seconds).
inline constexpr std::size_t kMostProbes = 600;

/// Of a surface that is solved for: memory grows with the square of their number, 600 MB.
inline constexpr std::size_t kMostBentProbes = 3000;

/// Of a grid model, which solves nothing: as many as a map's file has room for.
inline constexpr std::size_t kMostGridProbes = 50'000;

/// Probes of fewer places than this are not asked for bow and twist.
inline constexpr std::size_t kLeastForBow = 12;

/// Checks that a model takes this number of probes, and that all of them are numbers that a board
/// can have: within 1e6 mm of 0, sigmas of 1e-9 to 1e6 mm.
///
/// Fails  grid-invalid: too few or too many probes; a number outside of that
/// See    tests/surface/fit/fit_test.cc
Expected<void> check_probes(std::span<const ProbePoint> points, SurfaceModel model);

/// A surface fitted to probed heights, with its uncertainty at every place.
///
/// A value: copies share what was fitted.
class SurfaceFit {
 public:
  SurfaceModel model() const;
  /// Height and sigma of the surface itself: a probe there would scatter about it besides.
  HeightEstimate at(const Position<frame::Nominal>& place) const;
  /// The same for many places: faster, by matrix products.
  std::vector<HeightEstimate> at(std::span<const Position<frame::Nominal>> places) const;
  /// The heights alone, mm: O(n) each, where sigma takes O(n^2).
  std::vector<double> heights_mm(std::span<const Position<frame::Nominal>> places) const;

  /// Covariance of the surface's error from place to place, mm^2; its diagonal is sigma squared of
  /// at(), but for rounding. Unresolved bending is in the diagonal alone. Grid models do not know
  /// how errors hang together.
  ///
  /// Precondition: no grid model
  Eigen::MatrixXd covariance_mm2(std::span<const Position<frame::Nominal>> places) const;

  /// The same surface, its sigma with the bends that probes may show which were left out.
  ///
  /// Precondition: no grid model
  SurfaceFit with(std::vector<PossibleBend> bends) const;
  std::span<const PossibleBend> possible_bends() const;

  /// Shapes that the surface is the average of, heaviest first: one of all models but a Gaussian
  /// process.
  std::span<const ShapeShare> shapes() const;
  /// The heaviest.
  const SurfaceShape& shape() const;
  /// Ratio of the probes' scatter about the surface to their sigma: 1 if that is stated, but of a
  /// plane that they miss by more than chance allows.
  double noise_factor() const;
  /// Of sigma: what the probes tell of the noise factor, and what was believed before; if their
  /// scatter is stated, what they tell of the bending; infinite for a plane and for grid models.
  double degrees_of_freedom() const;
  /// Standard deviation of the heaviest shape's bending; 0 but for a Gaussian process.
  Length amplitude() const;
  /// Over which the bending changes; 0 where amplitude() is 0.
  Length length() const;
  /// False if the probes' places are no more than the trend's coefficients, however often each was
  /// probed: nothing tells how the board bends between them.
  bool has_seen_bending() const;
  /// Coefficients of the trend: 3 for a plane, 6 with bow and twist, 0 for grid models.
  int n_trend() const;
  /// In the order of the probes; trend, strength and length of the bending as they are.
  std::span<const LeftOutProbe> left_out() const;
  /// Root mean square of the deviations of probes that were left out, in units of what each probe
  /// is said to scatter. Empty if the others predict none of them.
  std::optional<double> left_out_rms() const;
  /// The model in words: `plane and a Gaussian bending of 0.112 mm over 104 mm (41 %, averaged with
  /// 5 others); the probes scatter as stated`.
  std::string summary() const;

 private:
  struct State;
  friend Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points, SurfaceModel model);
  friend Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                          SurfaceModel model,
                                          std::span<const ShapeShare> shapes);
  explicit SurfaceFit(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  /// Of no grid model. A noise factor that is learned takes the place of the shapes'.
  static Expected<SurfaceFit> solved(std::span<const ProbePoint> points,
                                     SurfaceModel model,
                                     std::span<const ShapeShare> shapes,
                                     bool learns_noise);

  std::shared_ptr<const State> state_;
};

/// Fits a surface to probed heights.
///
///   height_i = trend(place_i) + f(place_i) + e_i,   e_i ~ N(0, k^2 sigma_i^2)
///
/// f is a Gaussian process: none (plane), r^2 log r (thin plate), or the average of kernels and
/// lengths by their posterior weights (surface/fit/bending/bending_average.h): height and variance
/// are those of the mixture, so that sigma has what the shapes disagree in. The trend of a Gaussian
/// process is bow and twist, (1, x, y, x^2, x y, y^2), where the probes determine it and are
/// have kLeastForBow places or more; else a plane. Probes of three places see no bending, however
/// often they are repeated: they make the plane through them. The trend's error enters the sigma of
/// every height.
///
/// k is 1: stated scatter is believed, and what the probes miss more is bending. Of a plane that
/// they miss by more than chance allows, that has no room but SurfaceShape::unresolved, in every
/// sigma. If any scatter is assumed only (ProbePoint::is_sigma_assumed), k has the greatest
/// likelihood.
///
/// Of more than kMostProbes, an even part tells kernel, trend, strength and length: half of it all
/// over the panel, each with its nearest neighbour beside it, so that short lengths are seen too.
/// All of them make the surface of the heaviest shape, and tell k.
///
/// Grid models have neither trend nor noise factor: between the probes they interpolate, and sigma
/// has what that misses, as far as probes left out tell (surface/fit/grid_surface.h).
///
/// In     points: 3 or more; sigma above 0
/// Fails  as check_probes(); grid-invalid: probes in one line; for grid models a node without a
///        probe, two probes of one node, fewer than 3 columns or rows
/// Cost   some 20 tridiagonal forms of an m x m matrix for a Gaussian process, one for a thin
/// plate;
///        m the probes that tell the shape; O(n^3) to solve each shape
/// Source Rasmussen and Williams 2006, 2.7 (trend), 5.4.1, 5.4.2 (leaving one out); Dubrule 1983
///        (leaving one out with a trend); Patterson and Thompson 1971 (restricted likelihood)
/// See    tests/surface/fit/fit_test.cc, height_map_slow_test.cc
Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points, SurfaceModel model);

/// The same of a known shape: that of an earlier fit of the same probes gives the same surface to
/// the bit, one that is believed of a panel predicts how well probes would determine it.
///
/// Fails  as above, and as SurfaceShape::validate(); grid-invalid: the probes do not determine the
///        shape's trend
/// Cost   O(n^3); a height O(n^2)
Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                 SurfaceModel model,
                                 const SurfaceShape& shape);

/// The same of the average of known shapes.
///
/// Fails  as above, and as check_shares()
Expected<SurfaceFit> fit_surface(std::span<const ProbePoint> points,
                                 SurfaceModel model,
                                 std::span<const ShapeShare> shapes);

}  // namespace panelcal
