// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "vision/round/model/model.h"

namespace panelcal::internal {

/// The pixels near a rim, an array for each of their numbers: loops over these take four at a time.
/// Names, frames and units as in RimPixel.
struct RimBand {
  bool has_jacobian = false;  ///< else it is the identity, and its arrays are empty
  std::vector<float> at_x, at_y;
  std::vector<float> j00, j01, j10, j11;
  std::vector<float> plane_x, plane_y;
  std::vector<float> value;
  std::vector<float> weight;
  std::vector<std::int16_t> x, y;
  std::vector<std::int8_t> clipped;
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

  /// One pixel in a piece; i < size().
  RimPixel pixel(std::size_t i) const;

  /// Goes through the pixels in a piece.
  class Iterator {
   public:
    using difference_type = std::ptrdiff_t;
    using value_type = RimPixel;
    using reference = RimPixel;
    using pointer = void;
    using iterator_category = std::input_iterator_tag;

    Iterator(const RimBand& band, std::size_t i) : band_(&band), i_(i) {}
    RimPixel operator*() const { return band_->pixel(i_); }
    Iterator& operator++() {
      ++i_;
      return *this;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.i_ == b.i_; }

   private:
    const RimBand* band_;
    std::size_t i_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }
};

/// Some pixels of a band and the model's picture of them, as rim_value() has it but in floats.
///
/// Agrees with rim_value() to 5e-6 of the levels.
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
  /// Compares with what is seen: least squares, or with Huber's weights if huber > 0. Clipped
  /// pixels are taken like others.
  void weigh(const RimBand& band, double huber);

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
