// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "surface/fit/bending/bending_kernel.h"

namespace panelcal {

/// The models of a surface between its probes.
enum class SurfaceModel : std::uint8_t {
  Plane,
  ThinPlate,        ///< a plane, bent like a thin plate
  GaussianProcess,  ///< bow and twist, and a smooth random bending on top
  Bilinear,         ///< through every probe of a complete rectangular grid, not smoothed
  MonotoneBicubic,  ///< the same, smooth, and within the range of each cell's four probes
};

/// Bilinear and MonotoneBicubic: every probe is believed, and none may be missing.
constexpr bool is_of_grid(SurfaceModel model) {
  return model == SurfaceModel::Bilinear || model == SurfaceModel::MonotoneBicubic;
}

/// Coefficients of a trend: (1, x, y), and with (x^2, x y, y^2).
inline constexpr int kPlaneTrend = 3;
inline constexpr int kBowTrend = 6;

/// Bending of a surface and scatter of its probes: all that a fit finds besides the surface itself,
/// and all that it needs to be made again.
struct SurfaceShape {
  BendingKernel kernel = BendingKernel::None;
  Length length;              ///< over which it bends, the unit of r; 0 if nothing bends
  double strength_mm2 = 0;    ///< variance of the bending by the noise factor's square
  double noise_factor = 1;    ///< scatter of the probes by what they say
  int n_trend = kPlaneTrend;  ///< or kBowTrend with bow and twist; 0 of grid models
  /// Standard deviation of a bending that the model cannot follow and the probes' stated scatter
  /// does not explain; part of every sigma.
  Length unresolved = {};

  /// Fails  config-value, without a place: a number that makes no surface of this model
  /// See    tests/surface/fit/fit_test.cc
  Expected<void> validate(SurfaceModel model) const;
};

/// One of the shapes that a surface is the average of.
struct ShapeShare {
  SurfaceShape shape;
  double weight = 1;  ///< all together 1
};

/// Checks that shapes can be averaged to a surface: each one of this model, all of one trend and
/// one unresolved bending, weights above 0 that add up to 1; only a Gaussian process has several.
///
/// Fails  config-value, without a place
Expected<void> check_shares(std::span<const ShapeShare> shapes, SurfaceModel model);

/// "plane", "thin-plate", "gaussian-process", "bilinear", "monotone-bicubic", as files and options
/// have them.
std::string_view word(SurfaceModel model);
std::optional<SurfaceModel> surface_model(std::string_view word);
std::span<const std::string_view> surface_model_words();

/// "none", "thin-plate", "matern-3/2", "matern-5/2", "gaussian", "matern-1/2"
std::string_view word(BendingKernel kernel);
std::optional<BendingKernel> bending_kernel(std::string_view word);

}  // namespace panelcal
