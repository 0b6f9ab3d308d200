// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/round/model/model.h"

namespace panelcal::internal {

/// The pixels near a rim, an array for each of their numbers: loops over these take four at a time.
struct RimBand {
  bool has_jacobian = false;              ///< else it is the identity, and its arrays are empty
  std::vector<float> at_x, at_y;          ///< in the fit frame, from the window's origin
  std::vector<float> j00, j01, j10, j11;  ///< d at / d pixel
  std::vector<float> plane_x, plane_y;    ///< in window units, from the window's middle
  std::vector<float> value;               ///< grey level
  std::vector<float> weight;              ///< 1 / variance of its noise
  std::vector<std::int16_t> x, y;         ///< in the window
  std::vector<std::int8_t> clipped;       ///< 1: at full scale, -1: at zero
  bool has_clipped = false;

  std::size_t size() const { return value.size(); }
  /// Removes all pixels.
  void clear(bool with_jacobian);
  void reserve(std::size_t n);
  /// Adds n pixels of weight 1, to be filled in; returns the first one's index.
  std::size_t grow(std::size_t n);

  /// lanes[first + k] = start + k step for k = 0 .. n - 1.
  static void set_ramp(
      std::vector<float>& lanes, std::size_t first, std::size_t n, double start, double step);
};

/// Some pixels of a band and the picture of a disc or ring in them, as a function of its
/// parameters.
///
///   I = light (level + contrast (E(R) - E(R_inner)) + hole E(R_inner)) + slopes (E(R) -
///   E(R_inner))
///
/// with light = 1 + a linear function, E the edge profile and lengths measured in the fit frame,
/// then brought to pixels by the frame's local scale across the rim.
///
/// In floats; agrees with the same in doubles to 5e-6 of the levels
/// (tests/vision/round/model/rim_value.h).
/// See    tests/vision/round/model/band_test.cc
struct RimChunk {
  static constexpr std::size_t kSize = 64;
  using Lanes = std::array<float, kSize>;

  std::size_t first = 0;  ///< in the band
  std::size_t n = 0;      ///< the lanes behind repeat the last pixel
  Lanes level, share, distance_px, inner_px;
  /// Only of the parameters that `freedom` has.
  std::array<Lanes, kRimParameters> gradient;

  /// Of weigh(): model minus seen; root of the weight; cost, of which half the slope by the level
  /// is weight times residual. 0 in the lanes behind n.
  Lanes residual, root_weight, cost;

  enum class Want : std::uint8_t { Values, Gradient };
  /// In     first < band.size()
  void evaluate(const RimBand& band,
                std::size_t first_pixel,
                const RimVector& p,
                const RimFreedom& freedom,
                Want want);
  /// Compares with what is seen, by least squares. Clipped pixels are taken like others.
  void weigh(const RimBand& band);

 private:
  /// Places of the pixels; then one rim's part of the picture.
  struct Work {
    Lanes dx, dy, j00, j01, j10, j11, u, v, contrast;
    Lanes nx, ny, per_unit, distance, share, d_distance, d_sigma, d_radius;
  };
  static void load(const RimBand& band, std::size_t first, std::size_t n, Work& w);
  static void add_rim(const RimVector& p, double radius, bool has_jacobian, Work& w);
};

/// The model's picture of every pixel of a band.
struct RimBandValues {
  std::vector<float> level, share, distance_px;
};
RimBandValues band_values(const RimBand& band, const RimVector& p, bool is_ring);

/// The places of all pixels of a band, seen from a rim that is no oval.
struct RimPlaces {
  std::vector<float> distance_px;  ///< from the rim, inwards
  /// The direction of the pixel seen from the centre, counted from x towards y, in turns from 0
  /// to 1; to within 0.0002, as turn_of() has it.
  std::vector<float> turn;
};
RimPlaces rim_places(const RimBand& band, const RimVector& p);

}  // namespace panelcal::internal
