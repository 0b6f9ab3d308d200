// SPDX-License-Identifier: Apache-2.0
#include "vision/round/model/window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/vision/round/model/rim_value.h"

namespace panelcal::internal {
namespace {

constexpr double kReach = 5;

RimVector disc_parameters(double x, double y, double radius) {
  RimVector p = RimVector::Zero();
  p[kCenterX] = x;
  p[kCenterY] = y;
  p[kRadius] = radius;
  p[kSigma] = 1.1;
  p[kLevel] = 80;
  p[kContrast] = 100;
  return p;
}

RimVector ring_parameters() {
  RimVector p = disc_parameters(0.4, -0.3, 26);
  p[kInnerRadius] = 11;
  p[kHoleX] = 1.5;
  p[kHoleY] = -2;
  return p;
}

/// Levels without any order, so that no two sums agree by chance.
Image speckled(int width, int height, double low, double high, std::uint64_t seed) {
  Image image(width, height, 255);
  Random random(seed);
  for (float& v : image.pixels()) v = static_cast<float>(std::round(random.uniform(low, high)));
  return image;
}

CameraMapping lens() {
  return CameraMapping({.scale_mm_per_px = 0.01,
                        .rotation_rad = 0.15,
                        .axis_px = Eigen::Vector2d(200, -30),
                        .k1_per_px2 = 3 / std::pow(400.0, 3)});
}

/// Number of times that the spans hold each pixel, by rows of the window.
std::vector<int> span_counts(const RimWindow& window) {
  std::vector<int> counts(static_cast<std::size_t>(window.width() * window.height()), 0);
  for (const RimSpan& span : window.spans()) {
    for (int x = span.x0; x < span.x1; ++x) ++counts[window.index(x, span.y)];
  }
  return counts;
}

/// Every pixel within the circle of the window is in one span, every other one in none.
void expect_whole_circle(const RimWindow& window,
                         const FitFrame& frame,
                         const Eigen::Vector2d& center,
                         double outer) {
  // The window is a circle by the frame's linear part; what the lens bends is left to either side.
  const double slack = frame.mapping() ? 0.5 : 1e-6;
  const std::vector<int> counts = span_counts(window);
  int n_inside = 0;
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      const Eigen::Vector2d u(window.x0() + x, window.y0() + y);
      const double distance = (frame.from_image(u) - center).norm();
      const int count = counts[window.index(x, y)];
      const int least = distance < outer - slack ? 1 : 0;
      const int most = distance > outer + slack ? 0 : 1;
      EXPECT_GE(count, least) << u.transpose();
      EXPECT_LE(count, most) << u.transpose();
      n_inside += count;
    }
  }
  EXPECT_GT(n_inside, 1000);
}

TEST(RimWindow, SpansCoverTheCircleOnce) {
  const Image image = speckled(130, 120, 20, 230, 1);
  const FitFrame frame(nullptr, Eigen::Vector2d(62, 58));
  const RimVector p = ring_parameters();
  for (const bool is_ring : {false, true}) {
    RimWindow window(image, frame, p, 15, is_ring);
    window.collect(p, kReach, 1);
    expect_whole_circle(window, frame, p.head<2>(), p[kRadius] + 15);
    // The parameters move, the window does not.
    RimVector moved = p;
    moved[kCenterX] += 3;
    moved[kRadius] -= 2;
    window.collect(moved, kReach, 1);
    expect_whole_circle(window, frame, p.head<2>(), p[kRadius] + 15);
  }
}

TEST(RimWindow, SpansCoverTheCircleOnceBehindALens) {
  const Image image = speckled(130, 120, 20, 230, 2);
  const CameraMapping mapping = lens();
  const FitFrame frame(&mapping, Eigen::Vector2d(62, 58));
  RimWindow window(image, frame, ring_parameters(), 15, true);
  window.collect(ring_parameters(), kReach, 1);
  expect_whole_circle(window, frame, ring_parameters().head<2>(), 41);
}

TEST(RimWindow, EndsWhereThePictureEnds) {
  const Image image = speckled(70, 60, 20, 230, 3);
  const FitFrame frame(nullptr, Eigen::Vector2d(30, 28));
  const RimVector p = disc_parameters(0, 0, 26);
  RimWindow window(image, frame, p, 40, false);
  EXPECT_EQ(window.x0(), 0);
  EXPECT_EQ(window.y0(), 0);
  EXPECT_EQ(window.width(), 70);
  EXPECT_EQ(window.height(), 60);
  window.collect(p, kReach, 1);
  expect_whole_circle(window, frame, p.head<2>(), 66);
}

TEST(RimWindow, IsEmptyBesideThePicture) {
  const Image image = speckled(70, 60, 20, 230, 3);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(-200, 20), Eigen::Vector2d(20, 900)}) {
    const FitFrame frame(nullptr, at);
    EXPECT_TRUE(RimWindow(image, frame, disc_parameters(0, 0, 20), 20, false).empty());
  }
  const Image nothing;
  const FitFrame frame(nullptr, Eigen::Vector2d(0, 0));
  EXPECT_TRUE(RimWindow(nothing, frame, disc_parameters(0, 0, 20), 20, false).empty());
}

/// Near a rim, by the model's own distance: farther out the edge says nothing.
bool is_near_rim(const RimWindow& window, const FitFrame& frame, const RimVector& p, int x, int y) {
  RimPixel pixel;
  const Eigen::Vector2d u(window.x0() + x, window.y0() + y);
  pixel.at = frame.from_image(u).cast<float>();
  pixel.jacobian = frame.jacobian(u).cast<float>();
  pixel.plane.setZero();
  const RimValue value = rim_value(pixel, p, window.is_ring(), nullptr);
  return std::abs(value.distance_px) < kReach - 0.01 ||
         (window.is_ring() && std::abs(value.inner_px) < kReach - 0.01);
}

TEST(RimWindow, BandHoldsAllNearTheRimsAndZonesTheRest) {
  const Image image = speckled(130, 120, 20, 230, 4);
  const CameraMapping mapping = lens();
  RimVector oval = ring_parameters();
  oval[kOval] = 0.02;
  oval[kOvalDiagonal] = 0.01;
  for (const CameraMapping* m : {static_cast<const CameraMapping*>(nullptr), &mapping}) {
    for (const RimVector& p : {ring_parameters(), oval}) {
      const FitFrame frame(m, Eigen::Vector2d(62, 58));
      RimWindow window(image, frame, p, 15, true);
      window.collect(p, kReach, 1);
      for (const RimSpan& span : window.spans()) {
        if (span.is_band) continue;
        for (int x = span.x0; x < span.x1; ++x) {
          ASSERT_FALSE(is_near_rim(window, frame, p, x, span.y)) << x << " " << span.y;
          const Eigen::Vector2d u(window.x0() + x, window.y0() + span.y);
          const Eigen::Vector2d d = frame.from_image(u) - p.head<2>();
          const Eigen::Vector2d from_hole = d - p.segment<2>(kHoleX);
          const RimZone zone = d.norm() > p[kRadius]                ? RimZone::Outside
                               : from_hole.norm() > p[kInnerRadius] ? RimZone::Target
                                                                    : RimZone::Hole;
          ASSERT_EQ(span.zone, zone) << x << " " << span.y;
        }
      }
    }
  }
}

TEST(RimWindow, BandPixelsAreThePictureAndTheFrame) {
  Image image = speckled(130, 120, 20, 230, 5);
  const CameraMapping mapping = lens();
  const FitFrame frame(&mapping, Eigen::Vector2d(62, 58));
  const RimVector p = disc_parameters(0, 0, 26);
  image.at(62 + 26, 58) = 255;
  image.at(62 - 26, 58) = 0;
  RimWindow window(image, frame, p, 15, false);
  window.collect(p, kReach, 1);
  int n_clipped = 0;
  ASSERT_GT(window.band().size(), 500U);
  for (const RimPixel& pixel : pixels_of(window.band())) {
    const Eigen::Vector2d u(window.x0() + pixel.x, window.y0() + pixel.y);
    constexpr double kFloat = 1e-5;
    ASSERT_LT((pixel.at.cast<double>() - frame.from_image(u)).norm(), kFloat);
    ASSERT_LT((pixel.jacobian.cast<double>() - frame.jacobian(u)).norm(), kFloat);
    ASSERT_LT((pixel.plane.cast<double>() - window.plane_at(pixel.x, pixel.y)).norm(), kFloat);
    const float level = image.at(static_cast<int>(u.x()), static_cast<int>(u.y()));
    ASSERT_EQ(pixel.value, level);
    ASSERT_EQ(pixel.clipped, level == 255 ? 1 : level == 0 ? -1 : 0);
    n_clipped += pixel.clipped != 0;
  }
  EXPECT_EQ(n_clipped, 2);
}

/// The zones' sums pixel by pixel.
std::array<FlatMoments, kRimZones> brute_force(const RimWindow& window) {
  std::array<FlatMoments, kRimZones> sums;
  for (const RimSpan& span : window.spans()) {
    if (span.is_band) continue;
    FlatMoments& m = sums[static_cast<std::size_t>(span.zone)];
    for (int x = span.x0; x < span.x1; ++x) {
      const Eigen::Vector2d at = window.plane_at(x, span.y);
      const Eigen::Vector3d b(1, at.x(), at.y());
      m.bb += b * b.transpose();
      m.bv += b * static_cast<double>(window.value(x, span.y) - window.reference());
      ++m.n;
    }
  }
  return sums;
}

void expect_brute_force_sums(const RimWindow& window) {
  const auto exact = brute_force(window);
  for (std::size_t i = 0; i < kRimZones; ++i) {
    const FlatMoments& m = window.flat()[i];
    EXPECT_EQ(m.n, exact[i].n) << "zone " << i;
    if (exact[i].n == 0) continue;
    constexpr double kDouble = 1e-9;
    constexpr double kFloat = 1e-5;  // levels, of a zone's mean: rows are summed up as floats
    EXPECT_LT((m.bb - exact[i].bb).norm(), kDouble * exact[i].bb.norm()) << "zone " << i;
    EXPECT_LT((m.bv - exact[i].bv).norm() / m.n, 100 * kFloat) << "zone " << i;
  }
}

TEST(RimWindow, ZonesSumsEqualBruteForce) {
  const Image image = speckled(130, 120, 20, 230, 6);
  const FitFrame frame(nullptr, Eigen::Vector2d(62, 58));
  RimWindow window(image, frame, ring_parameters(), 15, true);
  window.collect(ring_parameters(), 3, 1);
  for (const FlatMoments& m : window.flat()) EXPECT_GT(m.n, 100);
  expect_brute_force_sums(window);
}

TEST(RimWindow, AClippedZoneIsTakenPixelByPixel) {
  Image image = speckled(130, 120, 20, 230, 9);
  const RimVector p = disc_parameters(0, 0, 26);
  for (int y = 32; y <= 84; ++y) {
    for (int x = 36; x <= 88; ++x) {
      if (std::hypot(x - 62, y - 58) < 26) image.at(x, y) = (x + y) % 3 == 0 ? 240 : 255;
    }
  }
  const FitFrame frame(nullptr, Eigen::Vector2d(62, 58));
  RimWindow window(image, frame, p, 15, false);
  window.collect(p, kReach, 1);
  EXPECT_EQ(window.flat()[static_cast<std::size_t>(RimZone::Target)].n, 0);
  EXPECT_GT(window.flat()[static_cast<std::size_t>(RimZone::Outside)].n, 1000);
  const bool has_middle = std::ranges::any_of(pixels_of(window.band()), [&](const RimPixel& pixel) {
    return window.x0() + pixel.x == 62 && window.y0() + pixel.y == 58;
  });
  EXPECT_TRUE(has_middle);
}

TEST(RimWindow, StrideTakesSomeRowsOfTheBandAndAllOfTheZones) {
  const Image image = speckled(130, 120, 20, 230, 10);
  const FitFrame frame(nullptr, Eigen::Vector2d(62, 58));
  const RimVector p = disc_parameters(0, 0, 26);
  RimWindow window(image, frame, p, 15, false);
  window.collect(p, kReach, 1);
  const auto all = window.flat();
  std::size_t n_even = 0;
  for (const RimPixel& pixel : pixels_of(window.band())) n_even += pixel.y % 2 == 0;
  window.collect(p, kReach, 2);
  EXPECT_EQ(window.band().size(), n_even);
  for (std::size_t i = 0; i < kRimZones; ++i) EXPECT_EQ(window.flat()[i].n, all[i].n);
}

}  // namespace
}  // namespace panelcal::internal
