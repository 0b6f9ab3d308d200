// SPDX-License-Identifier: Apache-2.0
#include "vision/round/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "vision/fit/turn.h"
#include <Eigen/Core>

namespace panelcal::internal {
namespace {

constexpr int kSectors = 48;

}  // namespace

std::vector<RimDeviation> rim_deviations(const RimWindow& window,
                                         const RimVector& p,
                                         const RimNoise& noise) {
  struct Sector {
    double slope = 0, curvature = 0;
  };
  std::array<Sector, kSectors> sectors{};
  const RimBand& band = window.band();
  RimFreedom freedom;
  freedom.is_ring = window.is_ring();
  RimChunk chunk;
  for (std::size_t i = 0; i < band.size(); ++i) {
    const std::size_t k = i % RimChunk::kSize;
    if (k == 0) chunk.evaluate(band, i, p, freedom, RimChunk::Want::Gradient);
    if (band.clipped[i] != 0) continue;
    if (std::abs(static_cast<double>(chunk.distance_px[k])) > 4 * p[kSigma]) continue;
    const double share = std::clamp(static_cast<double>(chunk.share[k]), 0.0, 1.0);
    const double in = noise[RimZone::Target];
    const double out = noise[RimZone::Outside];
    const double weight = 1 / (share * in * in + (1 - share) * out * out);
    const double turn = turn_of(static_cast<double>(band.at_x[i]) - p[kCenterX],
                                static_cast<double>(band.at_y[i]) - p[kCenterY]);
    Sector& s = sectors[static_cast<std::size_t>(turn * kSectors) % kSectors];
    const auto g = static_cast<double>(chunk.gradient[kRadius][k]);
    s.slope += weight * g * static_cast<double>(band.value[i] - chunk.level[k]);
    s.curvature += weight * g * g;
  }
  std::vector<RimDeviation> deviations(kSectors);
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    const Sector& s = sectors[i];
    if (s.curvature > 0) deviations[i] = {s.slope / s.curvature, 1 / s.curvature};
  }
  return deviations;
}

}  // namespace panelcal::internal
