// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/weave.h"

#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

constexpr double kYarnWander = 0.06;      // of the period, sideways
constexpr double kYarnInequality = 0.35;  // of a yarn's brightness
constexpr double kMottle = 0.35;          // share of the irregular part
constexpr double kMottleCell = 0.18;      // of the period

/// -1 to 1, from a lattice point; SplitMix64's mixing (Steele, Lea and Flood 2014).
double hash_level(std::int64_t i, std::int64_t j, std::uint64_t seed) {
  std::uint64_t z = seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL +
                    static_cast<std::uint64_t>(j) * 0xD1B54A32D192ED03ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

/// 0 to 1 with zero slope at both ends, so that cells join smoothly.
double smooth_step(double t) {
  return t * t * (3 - 2 * t);
}

double value_noise_1d(double x, std::int64_t lane, std::uint64_t seed) {
  const double floor_x = std::floor(x);
  const auto i = static_cast<std::int64_t>(floor_x);
  const double t = smooth_step(x - floor_x);
  return (1 - t) * hash_level(i, lane, seed) + t * hash_level(i + 1, lane, seed);
}

double value_noise_2d(double x, double y, std::uint64_t seed) {
  const double floor_y = std::floor(y);
  const auto j = static_cast<std::int64_t>(floor_y);
  const double t = smooth_step(y - floor_y);
  return (1 - t) * value_noise_1d(x, j, seed) + t * value_noise_1d(x, j + 1, seed);
}

}  // namespace

double weave_level(const Eigen::Vector2d& at_mm, double period_mm, std::uint64_t seed) {
  const double x = at_mm.x() / period_mm;
  const double y = at_mm.y() / period_mm;
  constexpr std::int64_t kWarp = 1'000'003;
  constexpr std::int64_t kWeft = 2'000'003;
  const double warp = x + kYarnWander * value_noise_1d(1.3 * y, kWarp, seed);
  const double weft = y + kYarnWander * value_noise_1d(1.3 * x, kWeft, seed);
  const double thickness =
      value_noise_1d(2 * x, kWarp + 1, seed) + value_noise_1d(2 * y, kWeft + 1, seed);
  const double knots =
      std::sin(2 * std::numbers::pi * warp) * std::sin(2 * std::numbers::pi * weft);
  const double mottle = value_noise_2d(x / kMottleCell, y / kMottleCell, seed + 7);
  return (1 - kMottle) * knots * (1 + kYarnInequality * thickness) + kMottle * mottle;
}

}  // namespace panelcal::internal
