// SPDX-License-Identifier: Apache-2.0
#include "vision/round/model/band.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/vision/round/model/rim_value.h"

namespace panelcal::internal {
namespace {

/// Of the levels: floats put a pixel and a rim 2e-6 px off each, a sharp edge makes that of the
/// level.
constexpr double kPromise = 5e-6;

RimVector ring_parameters() {
  RimVector p = RimVector::Zero();
  p[kCenterX] = 0.3;
  p[kCenterY] = -0.2;
  p[kRadius] = 20;
  p[kSigma] = 1.1;
  p[kLevel] = 60;
  p[kLightX] = 0.08;
  p[kLightY] = -0.05;
  p[kContrast] = 100;
  p[kInnerRadius] = 9;
  p[kHole] = -20;
  p[kHoleX] = 1.2;
  p[kHoleY] = -0.7;
  p[kOval] = 0.011;
  p[kOvalDiagonal] = -0.007;
  p[kContrastX] = 3;
  p[kContrastY] = -2;
  return p;
}

/// Pixels anywhere about the middle, as if behind a strong lens.
RimBand random_band(std::size_t n, bool has_jacobian, std::uint64_t seed) {
  Random random(seed);
  RimBand band;
  band.clear(has_jacobian);
  band.grow(n);
  for (std::size_t i = 0; i < n; ++i) {
    band.at_x[i] = static_cast<float>(random.uniform(-26, 26));
    band.at_y[i] = static_cast<float>(random.uniform(-26, 26));
    band.plane_x[i] = band.at_x[i] / 20;
    band.plane_y[i] = band.at_y[i] / 20;
    band.value[i] = static_cast<float>(random.uniform(0, 255));
    band.weight[i] = static_cast<float>(random.uniform(0.1, 2));
    if (!has_jacobian) continue;
    band.j00[i] = static_cast<float>(random.uniform(0.8, 1.2));
    band.j01[i] = static_cast<float>(random.uniform(-0.2, 0.2));
    band.j10[i] = static_cast<float>(random.uniform(-0.2, 0.2));
    band.j11[i] = static_cast<float>(random.uniform(0.8, 1.2));
  }
  return band;
}

void expect_reference(const RimBand& band, const RimVector& p, const RimFreedom& freedom) {
  std::array<int, kRimParameters> columns{};
  const int n_columns = freedom.columns(columns);
  RimChunk chunk;
  double steepest = 0;
  std::size_t n_pixels = 0;
  for (std::size_t first = 0; first < band.size(); first += RimChunk::kSize) {
    chunk.evaluate(band, first, p, freedom, RimChunk::Want::Gradient);
    for (std::size_t k = 0; k < chunk.n; ++k) {
      ++n_pixels;
      RimGradient exact{};
      const RimPixel pixel = pixel_of(band, first + k);
      const RimValue value = rim_value(pixel, p, freedom.is_ring, &exact);
      ASSERT_NEAR(chunk.level[k], value.level, kPromise * 255);
      ASSERT_NEAR(chunk.share[k], value.share, kPromise);
      ASSERT_NEAR(chunk.distance_px[k], value.distance_px, kPromise * 40);
      if (freedom.is_ring) {
        ASSERT_NEAR(chunk.inner_px[k], value.inner_px, kPromise * 40);
      }
      steepest = std::max(steepest, std::abs(exact[kRadius]));
      for (int i = 0; i < n_columns; ++i) {
        const auto column = static_cast<std::size_t>(columns[static_cast<std::size_t>(i)]);
        const double unit = column == kOval || column == kOvalDiagonal ? p[kRadius] : 1;
        ASSERT_NEAR(chunk.gradient[column][k], exact[column], 10 * kPromise * 255 * unit)
            << "parameter " << column << " pixel " << first + k;
      }
    }
  }
  EXPECT_EQ(n_pixels, band.size());
  EXPECT_GT(steepest, 3);  // levels per px: some pixels are on the rim
}

TEST(RimBand, AgreesWithTheModelPixelByPixel) {
  // Not a multiple of the chunk's size.
  for (const bool has_jacobian : {false, true}) {
    const RimBand band = random_band(2011, has_jacobian, 1);
    for (const bool is_ring : {false, true}) {
      expect_reference(
          band, ring_parameters(), {.is_ring = is_ring, .is_oval = true, .has_own_slope = true});
      RimVector dark = ring_parameters();
      dark[kContrast] = -55;
      dark[kSigma] = 0.5;
      expect_reference(band, dark, {.is_ring = is_ring});
      dark[kSigma] = 4;
      expect_reference(band, dark, {.is_ring = is_ring});
    }
  }
}

TEST(RimBand, ValuesAreThoseOfTheChunks) {
  const RimBand band = random_band(200, true, 2);
  const RimVector p = ring_parameters();
  const RimBandValues values = band_values(band, p, true);
  ASSERT_EQ(values.level.size(), 200U);
  for (std::size_t i = 0; i < band.size(); ++i) {
    const RimValue value = rim_value(pixel_of(band, i), p, true, nullptr);
    ASSERT_NEAR(values.level[i], value.level, kPromise * 255);
    ASSERT_NEAR(values.share[i], value.share, kPromise);
    ASSERT_NEAR(values.distance_px[i], value.distance_px, kPromise * 40);
  }
}

TEST(RimBand, WeighsOnlyWhatIsThere) {
  const RimBand band = random_band(70, false, 3);
  const RimVector p = ring_parameters();
  RimChunk chunk;
  for (const std::size_t first : {std::size_t{0}, RimChunk::kSize}) {
    chunk.evaluate(band, first, p, {}, RimChunk::Want::Values);
    chunk.weigh(band);
    for (std::size_t k = 0; k < RimChunk::kSize; ++k) {
      if (k >= chunk.n) {
        ASSERT_EQ(chunk.root_weight[k], 0);
        ASSERT_EQ(chunk.cost[k], 0);
        continue;
      }
      const RimPixel pixel = pixel_of(band, first + k);
      const double weight = static_cast<double>(pixel.weight);
      const double residual =
          rim_value(pixel, p, false, nullptr).level - static_cast<double>(pixel.value);
      const double cost = weight * residual * residual;
      ASSERT_NEAR(chunk.residual[k], residual, kPromise * 255);
      ASSERT_NEAR(chunk.cost[k], cost, 1e-4 * (1 + cost));
      ASSERT_NEAR(chunk.root_weight[k], std::sqrt(weight), 1e-5);
    }
  }
}

/// The reference has the distance in the frame and, where the frame is bent, the rim's own
/// direction: what RimChunk measures for an edge, less the oval.
TEST(RimBand, PlacesAreThoseOfTheRim) {
  constexpr double kTurnPromise = 0.0002;
  RimVector p = ring_parameters();
  p[kOval] = p[kOvalDiagonal] = 0;
  for (const bool has_jacobian : {false, true}) {
    const RimBand band = random_band(500, has_jacobian, 7);
    const RimPlaces places = rim_places(band, p);
    const RimBandValues values = band_values(band, p, false);
    for (std::size_t i = 0; i < band.size(); ++i) {
      ASSERT_NEAR(places.distance_px[i], values.distance_px[i], 1e-5F) << i;
      const double angle = std::atan2(static_cast<double>(band.at_y[i]) - p[kCenterY],
                                      static_cast<double>(band.at_x[i]) - p[kCenterX]);
      const double turn = angle / (2 * std::numbers::pi);
      ASSERT_NEAR(places.turn[i], turn < 0 ? turn + 1 : turn, kTurnPromise) << i;
    }
  }
}

TEST(RimBand, ThePlaceOfTheCenterIsFinite) {
  RimBand band;
  band.clear(true);
  band.grow(1);
  band.j00[0] = band.j11[0] = 1;
  RimVector p = RimVector::Zero();
  p[kRadius] = 5;
  const RimPlaces places = rim_places(band, p);
  EXPECT_TRUE(std::isfinite(places.distance_px[0]));
  EXPECT_EQ(places.turn[0], 0);
}

}  // namespace
}  // namespace panelcal::internal
