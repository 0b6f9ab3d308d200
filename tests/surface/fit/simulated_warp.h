// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "surface/fit/probe_point.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal::test {

inline constexpr double kWarpSide_mm = 300;
inline constexpr double kWarpRange_mm = 0.3;
inline constexpr double kWarpSigma_mm = 0.003;

/// A smooth warp of a panel of 300 x 300 mm about the origin, 0.3 mm from its lowest to its highest
/// place. By turns: bow and twist; waves of 200 to 600 mm; dents of 60 to 150 mm; bow, twist and
/// waves.
class SimulatedWarp {
 public:
  SimulatedWarp(Random& random, int kind) {
    if (kind % 4 == 0 || kind % 4 == 3) {
      for (double& c : bow_) c = random.normal();
    }
    const int n_waves = kind % 2 == 1 ? 4 : 0;
    for (int i = 0; i < n_waves; ++i) {
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const double by_length = 2 * std::numbers::pi * kWarpSide_mm / random.uniform(200, 600);
      const double phase = random.uniform(0, 2 * std::numbers::pi);
      waves_.push_back(
          {by_length * Eigen::Vector2d(std::cos(angle), std::sin(angle)), phase, random.normal()});
    }
    const int n_dents = kind % 4 == 2 ? 3 : 0;
    for (int i = 0; i < n_dents; ++i) {
      const double x = random.uniform(-0.5, 0.5), y = random.uniform(-0.5, 0.5);
      const double width = random.uniform(60, 150) / kWarpSide_mm;
      dents_.push_back({{x, y}, width, random.normal()});
    }
    double low = (*this)({0, 0}), high = low;
    constexpr int kSamples = 60;
    for (int i = 0; i <= kSamples; ++i) {
      for (int j = 0; j <= kSamples; ++j) {
        const double z =
            (*this)(kWarpSide_mm * (Eigen::Vector2d(i, j) / kSamples - Eigen::Vector2d(0.5, 0.5)));
        low = std::min(low, z);
        high = std::max(high, z);
      }
    }
    scale_ = kWarpRange_mm / (high - low);
  }

  /// mm
  double operator()(const Eigen::Vector2d& place_mm) const {
    const Eigen::Vector2d p = place_mm / kWarpSide_mm;
    double z = bow_[0] * p.x() * p.x() + bow_[1] * p.x() * p.y() + bow_[2] * p.y() * p.y();
    for (const Wave& wave : waves_) z += wave.height * std::cos(wave.by_place.dot(p) + wave.phase);
    for (const Dent& dent : dents_) {
      z += dent.height * std::exp(-0.5 * (p - dent.center).squaredNorm() / dent.width / dent.width);
    }
    return scale_ * z;
  }

 private:
  struct Wave {
    Eigen::Vector2d by_place;
    double phase;
    double height;
  };
  struct Dent {
    Eigen::Vector2d center;
    double width;
    double height;
  };
  double bow_[3] = {};
  std::vector<Wave> waves_;
  std::vector<Dent> dents_;
  double scale_ = 1;
};

/// Probes of a warp on a lattice of so many columns and rows that ends at the panel's edges.
template <class Surface>
std::vector<ProbePoint> probed_lattice(Random& random,
                                       const Surface& surface,
                                       int n_columns,
                                       int n_rows,
                                       double sigma_mm = kWarpSigma_mm) {
  std::vector<ProbePoint> points;
  for (int j = 0; j < n_rows; ++j) {
    for (int i = 0; i < n_columns; ++i) {
      const Eigen::Vector2d p_mm(kWarpSide_mm * (i / (n_columns - 1.0) - 0.5),
                                 kWarpSide_mm * (j / (n_rows - 1.0) - 0.5));
      const double z_mm = surface(p_mm) + sigma_mm * random.normal();
      points.push_back({position_mm<frame::Nominal>(p_mm),
                        {mm(z_mm), mm(sigma_mm)},
                        fmt::format("column {} row {}", i, j),
                        {"probes.jsonl", static_cast<int>(points.size()) + 1, 0}});
    }
  }
  return points;
}

}  // namespace panelcal::test
