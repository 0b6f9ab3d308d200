// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace panelcal {

/// Seeded random numbers that are the same with every standard library, so that a seed in a report
/// names one data set for ever (the distributions of <random> are not portable, its engines are).
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed), engine_(seed) {}

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

  /// A generator of its own for part number `part` of the work, whatever was drawn before
  /// (mixing as in SplitMix64, Steele, Lea and Flood 2014).
  Random fork(std::uint64_t part) const {
    std::uint64_t z = seed_ + (part + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return Random(z ^ (z >> 31));
  }

 private:
  std::uint64_t seed_;
  std::mt19937_64 engine_;
};

}  // namespace panelcal
