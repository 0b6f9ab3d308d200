// SPDX-License-Identifier: Apache-2.0
#include "tests/vision/fit/edge_profile.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "vision/fit/coverage.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

std::vector<OutlineNode> circle(double x, double y, double radius, int n) {
  std::vector<OutlineNode> nodes;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    nodes.push_back({{x + radius * std::cos(a), y + radius * std::sin(a)},
                     radius * std::cos(a) * 2 * std::numbers::pi / n});
  }
  return nodes;
}

ShareMap share_inside(const std::vector<OutlineNode>& nodes, double blur, int width, int height) {
  return integrate_inside(nodes, PixelResponse(blur), width, height);
}

/// Largest difference of the profile and the exact integral over all pixels.
double worst_error(double radius, double blur) {
  constexpr int kSide = 64;
  const double x0 = 31.3;
  const double y0 = 31.8;
  const ShareMap exact = share_inside(circle(x0, y0, radius, 2000), blur, kSide, kSide);
  double worst = 0;
  for (int y = exact.y0; y < exact.y1(); ++y) {
    for (int x = exact.x0; x < exact.x1(); ++x) {
      const double r = std::hypot(x - x0, y - y0);
      if (r < 1) continue;
      const EdgeValue edge = edge_profile(
          radius - r, std::sqrt(blur * blur + kPixelVariance), radius, (x - x0) / r, (y - y0) / r);
      worst = std::max(worst, std::abs(edge.share - exact.at(x, y)));
    }
  }
  return worst;
}

TEST(EdgeProfile, AgreesWithTheExactIntegral) {
  EXPECT_LT(worst_error(25, 1.0), 3e-4);
  EXPECT_LT(worst_error(25, 0.5), 1e-3);
  EXPECT_LT(worst_error(8, 1.0), 3e-3);
}

TEST(EdgeProfile, DerivativesAgreeWithDifferences) {
  constexpr double kStep = 1e-5;
  constexpr double kTolerance = 5e-7;  // the slope of the table, good to 1e-8 in itself
  const double nx = 0.6;
  const double ny = 0.8;
  for (const double d : {-2.0, -0.7, 0.0, 0.4, 1.9}) {
    const EdgeValue at = edge_profile(d, 0.9, 12, nx, ny);
    const auto slope = [](const EdgeValue& high, const EdgeValue& low) {
      return (high.share - low.share) / (2 * kStep);
    };
    EXPECT_NEAR(
        at.d_distance,
        slope(edge_profile(d + kStep, 0.9, 12, nx, ny), edge_profile(d - kStep, 0.9, 12, nx, ny)),
        kTolerance);
    EXPECT_NEAR(
        at.d_sigma,
        slope(edge_profile(d, 0.9 + kStep, 12, nx, ny), edge_profile(d, 0.9 - kStep, 12, nx, ny)),
        kTolerance);
    EXPECT_NEAR(
        at.d_radius,
        slope(edge_profile(d, 0.9, 12 + kStep, nx, ny), edge_profile(d, 0.9, 12 - kStep, nx, ny)),
        kTolerance);
  }
}

TEST(EdgeProfile, IsZeroOutsideAndOneInside) {
  EXPECT_EQ(edge_profile(-20, 1, 30, 1, 0).share, 0);
  EXPECT_EQ(edge_profile(20, 1, 30, 1, 0).share, 1);
}

TEST(GaussTable, AgreesWithErfcAndExp) {
  constexpr double kPromised = 1e-8;
  constexpr int kPlaces = 100'000;  // no multiple of the knots
  for (int i = 0; i <= kPlaces; ++i) {
    const double t = kEdgeReach * (2.0 * i / kPlaces - 1);
    const GaussValue value = gauss(t);
    ASSERT_NEAR(value.cdf, 0.5 * std::erfc(-t / std::numbers::sqrt2), kPromised) << t;
    ASSERT_NEAR(value.pdf, std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi), kPromised)
        << t;
  }
}

TEST(GaussTable, ReachesWhereTheEdgeEnds) {
  constexpr double kPromised = 1e-8;
  EXPECT_LT(0.5 * std::erfc(kEdgeReach / std::numbers::sqrt2), 1.1 * kPromised);
  EXPECT_NEAR(gauss(kEdgeReach).cdf, 1, 2 * kPromised);
  EXPECT_NEAR(gauss(-kEdgeReach).cdf, 0, 2 * kPromised);
}

TEST(Coverage, SharesAddUpToTheArea) {
  const ShareMap map = share_inside(circle(20.3, 17.9, 9.5, 400), 0.8, 48, 40);
  double sum = 0;
  for (const double share : map.share) sum += share;
  EXPECT_NEAR(sum, std::numbers::pi * 9.5 * 9.5, 1e-6);
}

TEST(Coverage, AgreesWithAFineGrid) {
  const double blur = 0.7;
  const ShareMap map = share_inside(circle(10.2, 9.6, 5.5, 400), blur, 21, 21);
  // Pixel (14, 12) by brute force: points of the pixel, moved by the lens, are they inside?
  double sum = 0;
  double weight = 0;
  constexpr int kPerPixel = 10;
  for (int i = -5 * kPerPixel; i <= 5 * kPerPixel; ++i) {
    for (int j = -5 * kPerPixel; j <= 5 * kPerPixel; ++j) {
      const double dx = static_cast<double>(i) / kPerPixel;
      const double dy = static_cast<double>(j) / kPerPixel;
      const double w = std::exp(-0.5 * (dx * dx + dy * dy) / (blur * blur));
      for (int k = 0; k < 8; ++k) {
        for (int l = 0; l < 8; ++l) {
          const double x = 14 + dx + (k + 0.5) / 8 - 0.5;
          const double y = 12 + dy + (l + 0.5) / 8 - 0.5;
          weight += w;
          sum += std::hypot(x - 10.2, y - 9.6) < 5.5 ? w : 0;
        }
      }
    }
  }
  constexpr double kGridError = 1e-3;
  EXPECT_NEAR(map.at(14, 12), sum / weight, kGridError);
}

TEST(Coverage, OutlinesOutsideOfThePictureCoverNothing) {
  EXPECT_TRUE(share_inside(circle(-100, 20, 10, 100), 1, 64, 64).share.empty());
  EXPECT_TRUE(share_inside(circle(1e9, 1e9, 10, 100), 1, 64, 64).share.empty());
  EXPECT_TRUE(share_inside({}, 1, 64, 64).share.empty());
}

TEST(Coverage, AnOutlineAroundThePictureCoversItAll) {
  const ShareMap map = share_inside(circle(10, 10, 500, 10000), 1, 20, 20);
  ASSERT_EQ(map.share.size(), 400U);
  for (const double share : map.share) EXPECT_NEAR(share, 1, 1e-9);
}

}  // namespace
}  // namespace panelcal::internal
