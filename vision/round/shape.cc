// SPDX-License-Identifier: Apache-2.0
#include "vision/round/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "vision/fit/turn.h"
#include <Eigen/Core>

namespace panelcal::internal {
namespace {

constexpr int kSectors = 48;

/// Values around the rim as cos and sin of n periods: their amplitudes.
Eigen::Vector2d wave(const std::vector<double>& values, int n_periods) {
  const auto n = static_cast<double>(values.size());
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double phi = 2 * std::numbers::pi * n_periods * static_cast<double>(i) / n;
    sum += values[i] * Eigen::Vector2d(std::cos(phi), std::sin(phi));
  }
  return (n_periods == 0 ? 1 : 2) / n * sum;
}

/// Deviations with far ones pulled in; empty if much of the rim is not seen.
std::vector<double> tamed(const std::vector<RimDeviation>& deviations) {
  constexpr double kFar = 3 * 1.4826;  // medians of the magnitudes: three normal sigmas
  constexpr double kLeastSeen = 0.75;
  std::vector<double> magnitudes;
  for (const RimDeviation& d : deviations) {
    if (d.variance > 0) magnitudes.push_back(std::abs(d.px));
  }
  if (static_cast<double>(magnitudes.size()) < kLeastSeen * kSectors) return {};
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  const double limit = kFar * *middle;
  std::vector<double> values;
  for (const RimDeviation& d : deviations) {
    values.push_back(d.variance > 0 ? std::clamp(d.px, -limit, limit) : 0);
  }
  return values;
}

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

RimRoughness rim_roughness(const std::vector<RimDeviation>& deviations) {
  constexpr double kKept = 0.8;
  constexpr std::size_t kFewSectors = 12;
  // Squared deviations and what noise makes of them.
  std::vector<std::pair<double, double>> squares;
  for (const RimDeviation& d : deviations) {
    if (d.variance > 0) squares.emplace_back(d.px * d.px, d.variance);
  }
  if (squares.size() < kFewSectors) return {};
  std::sort(squares.begin(), squares.end());
  squares.resize(static_cast<std::size_t>(kKept * static_cast<double>(squares.size())));
  double seen = 0;
  double by_chance = 0;
  for (const auto& [square, variance] : squares) {
    seen += square;
    by_chance += variance;
  }
  const auto n = static_cast<double>(squares.size());
  // The smaller four fifths of squared normal numbers have a mean of 0.47 and a spread of 0.45.
  constexpr double kTrimmedMean = 0.47;
  constexpr double kTrimmedSpread = 0.45;
  RimRoughness result;
  result.rms_px = std::sqrt(std::max(0.0, seen - kTrimmedMean * by_chance) / n);
  result.significance = (seen / by_chance - kTrimmedMean) * std::sqrt(n) / kTrimmedSpread;
  return result;
}

RimLobes rim_lobes(const std::vector<RimDeviation>& deviations) {
  constexpr int kFewest = 3;
  constexpr int kMost = 8;
  const std::vector<double> values = tamed(deviations);
  if (values.empty()) return {};
  RimLobes lobes;
  for (int n = kFewest; n <= kMost; ++n) {
    const double amplitude = wave(values, n).norm();
    if (amplitude > lobes.amplitude_px) lobes = {n, amplitude, 0};
  }
  if (lobes.n == 0) return {};
  // What the fit settles itself - radius, centre, oval - is no noise either.
  double rest = 0;
  for (const double v : values) rest += v * v;
  rest -= kSectors * wave(values, 0).squaredNorm();
  for (const int n : {1, 2, lobes.n}) rest -= 0.5 * kSectors * wave(values, n).squaredNorm();
  constexpr double kSettled = 7;  // amplitudes
  constexpr double kRounding = 1e-12;
  const double variance = std::max(rest / (kSectors - kSettled), kRounding);
  lobes.significance = lobes.amplitude_px * lobes.amplitude_px * kSectors / (4 * variance);
  return lobes;
}

}  // namespace panelcal::internal
