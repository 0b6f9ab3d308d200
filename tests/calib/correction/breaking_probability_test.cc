// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/breaking_probability.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using std::numbers::pi;

Eigen::Matrix2d ellipse(double large_mm, double small_mm, double angle_rad = 0) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  Eigen::Matrix2d axes;
  axes << c, -s, s, c;
  const Eigen::Vector2d squares(large_mm * large_mm, small_mm * small_mm);
  return axes * squares.asDiagonal() * axes.transpose();
}

/// The same probability without polar coordinates, for large = 1: the tails along the longer axis,
/// and across each strip between them what lies outside the circle. Everything is positive, so the
/// tails keep their digits.
double by_cartesian_strips(double radius, double small) {
  constexpr int kPanels = 4000;  // of Simpson's rule
  const auto outside = [&](double angle) {
    const double x = radius * std::sin(angle);
    const double y = radius * std::cos(angle);
    const double across = small > 0 ? std::erfc(y / (small * std::numbers::sqrt2)) : 0;
    return y * std::exp(-x * x / 2) / std::sqrt(2 * pi) * across;
  };
  // The feature at the ends, where the circle closes, gets the finest panels.
  const auto graded = [](double u) { return pi / 2 * std::sin(pi / 2 * u); };
  const auto integrand = [&](double u) {
    return outside(graded(u)) * pi / 2 * std::cos(pi / 2 * u) * pi / 2;
  };
  double sum = 0;
  for (int i = 0; i < kPanels; ++i) {
    const double a = -1 + 2.0 * i / kPanels;
    const double h = 2.0 / kPanels;
    sum += h / 6 * (integrand(a) + 4 * integrand(a + h / 2) + integrand(a + h));
  }
  return std::erfc(radius / std::numbers::sqrt2) + sum;
}

TEST(BreakingProbability, OfACircleIsRayleighs) {
  for (const double ratio : {0.01, 0.3, 1.0, 3.0, 6.0, 7.4, 9.0, 9.5}) {
    const double expected = std::exp(-ratio * ratio / 2);
    EXPECT_NEAR(breaking_probability(ellipse(0.01, 0.01), mm(0.01 * ratio)) / expected, 1, 1e-9)
        << "ratio " << ratio;
  }
}

TEST(BreakingProbability, OfALineIsTheErrorFunctions) {
  for (const double ratio : {0.001, 0.05, 0.09, 0.11, 0.5, 1.0, 2.5, 5.0, 7.1, 9.0, 9.5}) {
    const double expected = std::erfc(ratio / std::numbers::sqrt2);
    EXPECT_NEAR(breaking_probability(ellipse(0.01, 0, 0.7), mm(0.01 * ratio)) / expected, 1, 1e-6)
        << "ratio " << ratio;
  }
}

/// The contract: a millionth, for every shape, from certainty to 1e-12 and beyond.
TEST(BreakingProbability, AgreesWithAnIndependentIntegral) {
  for (const double small : {0.0, 1e-4, 0.003, 0.01, 0.03, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0}) {
    for (const double radius : {0.002,
                                0.02,
                                0.0999,
                                0.1001,
                                0.2,
                                0.5,
                                0.9,
                                1.0,
                                1.6,
                                2.0,
                                2.9,
                                3.1,
                                4.5,
                                6.0,
                                7.2,
                                8.1,
                                9.5}) {
      EXPECT_NEAR(breaking_probability(ellipse(1, small, 0.4), mm(radius)) /
                      by_cartesian_strips(radius, small),
                  1,
                  1e-6)
          << "small " << small << ", radius " << radius;
    }
  }
}

TEST(BreakingProbability, AgreesWithDraws) {
  constexpr int kDraws = 400'000;
  constexpr std::uint64_t kSeed = 20260701;
  Random random(kSeed);
  const Eigen::Matrix2d cov_mm2 = ellipse(0.010, 0.004, -1.1);
  const double c = std::cos(-1.1);
  const double s = std::sin(-1.1);
  std::vector<double> radii_mm = {0.003, 0.008, 0.015, 0.025};
  std::vector<int> broken(radii_mm.size());
  double sum = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = 0.010 * random.normal();
    const double v = 0.004 * random.normal();
    const double length = std::hypot(c * u - s * v, s * u + c * v);
    sum += length;
    for (std::size_t k = 0; k < radii_mm.size(); ++k) {
      if (length > radii_mm[k]) ++broken[k];
    }
  }
  for (std::size_t k = 0; k < radii_mm.size(); ++k) {
    const double p = breaking_probability(cov_mm2, mm(radii_mm[k]));
    const double sigma = std::sqrt(p * (1 - p) / kDraws);
    EXPECT_NEAR(static_cast<double>(broken[k]) / kDraws, p, 4 * sigma) << radii_mm[k] << " mm";
  }
  const double mean = mean_radial_error(principal_sigmas(cov_mm2)).in_mm();
  const double variance = cov_mm2.trace() - mean * mean;
  EXPECT_NEAR(sum / kDraws, mean, 4 * std::sqrt(variance / kDraws));
}

TEST(BreakingProbability, FallsWithTheRadiusAndRisesWithTheError) {
  for (const double small : {0.0, 0.05, 0.3, 1.0}) {
    double previous = 1;
    for (int i = 1; i < 950; ++i) {
      const double p = breaking_probability(ellipse(1, small), mm(0.01 * i));
      ASSERT_LT(p, previous) << "small " << small << ", radius " << 0.01 * i;
      ASSERT_LE(p, breaking_probability(ellipse(1.01, small), mm(0.01 * i)));
      previous = p;
    }
  }
}

TEST(BreakingProbability, OfExactPlacesIsZeroAndOfUnknownOnesOne) {
  EXPECT_EQ(breaking_probability(Eigen::Matrix2d::Zero(), um(1)), 0);
  EXPECT_EQ(breaking_probability(ellipse(0.01, 0.01), um(0)), 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(breaking_probability(Eigen::Matrix2d::Constant(nan), um(1)), 1);
  EXPECT_EQ(breaking_probability(infinite * Eigen::Matrix2d::Identity(), um(1)), 1);
  EXPECT_EQ(breaking_probability(ellipse(0.01, 0.01), mm(nan)), 1);
  // Rounding may leave a line with a negative eigenvalue.
  Eigen::Matrix2d line;
  line << 1, 1 + 1e-15, 1 + 1e-15, 1;
  EXPECT_NEAR(breaking_probability(line, mm(3 * std::numbers::sqrt2)),
              std::erfc(3 / std::numbers::sqrt2),
              1e-8);
}

TEST(BreakingProbability, IsTheSameFromTheStoreOfTheLast) {
  BreakingRisk risk;
  EXPECT_EQ(risk(Eigen::Matrix2d::Zero(), Length()), 1 - 1);
  for (const double sigma : {0.01, 0.01, 0.02, 0.01}) {
    for (const double radius : {0.03, 0.04}) {
      EXPECT_EQ(risk(ellipse(sigma, 0.01), mm(radius)),
                breaking_probability(ellipse(sigma, 0.01), mm(radius)));
    }
  }
}

TEST(MeanRadialError, IsAnEllipticIntegral) {
  for (const double small : {0.0, 1e-10, 1e-6, 0.01, 0.3, 0.77, 1.0}) {
    const double expected =
        std::sqrt(2 / pi) * std::comp_ellint_2(std::sqrt(1 - small * small)) * 0.02;
    EXPECT_NEAR(mean_radial_error({mm(0.02), mm(0.02 * small)}).in_mm() / expected, 1, 1e-12)
        << "small " << small;
  }
  EXPECT_EQ(mean_radial_error({}).in_mm(), 0);
}

TEST(RadiusExceeded, InvertsTheProbability) {
  for (const double small : {0.0, 0.02, 0.3, 0.7, 1.0}) {
    for (const double probability : {0.3, 0.05, 1e-3, 1e-9}) {
      const Length radius = radius_exceeded({um(7), um(7 * small)}, probability);
      EXPECT_NEAR(
          breaking_probability(ellipse(0.007, 0.007 * small), radius) / probability, 1, 1e-6)
          << "small " << small << ", probability " << probability;
    }
  }
  EXPECT_EQ(radius_exceeded({}, 0.05).in_mm(), 0);
  // The tables' 95 % radius of a circle.
  EXPECT_NEAR(radius_exceeded({mm(1), mm(1)}, 0.05).in_mm(), 2.447747, 1e-6);
}

/// Sigmas far below the tolerance, as files may state them, take no time and no wrong turn.
TEST(BreakingProbability, IsNothingBelow1em20) {
  for (const double sigma_mm : {1e-3, 1e-6, 1e-9, 1e-12, 1e-150}) {
    EXPECT_EQ(breaking_probability(ellipse(sigma_mm, sigma_mm / 3), mm(0.05)), 0) << sigma_mm;
  }
  // exp(-ratio^2 / 2) of a circle
  const double ratio = std::sqrt(2 * 20 * std::log(10.0));
  EXPECT_EQ(breaking_probability(ellipse(1, 1), mm(ratio * 1.0001)), 0);
  EXPECT_NEAR(breaking_probability(ellipse(1, 1), mm(ratio * 0.9999)) / 1e-20, 1, 0.01);
}

}  // namespace
}  // namespace panelcal
