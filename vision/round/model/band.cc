// SPDX-License-Identifier: Apache-2.0
// Compiled so that its loops run over several lanes at once: see CMakeLists.txt. The answer is the
// same without, only slower.
#include "vision/round/model/band.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "vision/fit/gauss_table.h"
#include "vision/fit/turn.h"

namespace panelcal::internal {
namespace {

constexpr std::size_t kSize = RimChunk::kSize;
using Lanes = RimChunk::Lanes;

/// 2^y to 2e-7 of itself, for y in -60 .. 0.
inline float power_of_two(float y) {
  const int whole = static_cast<int>(y - 0.5F);
  const float f = (y - static_cast<float>(whole)) * std::numbers::ln2_v<float>;
  const float taylor =
      1 + f * (1 + f * (1.0F / 2 +
                        f * (1.0F / 6 + f * (1.0F / 24 + f * (1.0F / 120 + f * (1.0F / 720))))));
  return taylor * std::bit_cast<float>((whole + 127) << 23);
}

/// The normal distribution's upper tail over its density's exponential, for t >= 0: with that
/// factor to 1e-7. Source Abramowitz and Stegun 1964, 7.1.26
inline float tail_factor(float t) {
  const float k = 1 / (1 + 0.3275911F / std::numbers::sqrt2_v<float> * t);
  return 0.5F * k *
         (0.254829592F +
          k * (-0.284496736F + k * (1.421413741F + k * (-1.453152027F + k * 1.061405429F))));
}

template <class T>
void copy_lanes(const std::vector<T>& from, std::size_t first, std::size_t n, Lanes& to) {
  std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first), n, to.begin());
  std::fill(to.begin() + static_cast<std::ptrdiff_t>(n), to.end(), to[n - 1]);
}

}  // namespace

void RimBand::clear(bool with_jacobian) {
  has_jacobian = with_jacobian;
  has_clipped = false;
  for (auto* lanes : {&at_x, &at_y, &j00, &j01, &j10, &j11, &plane_x, &plane_y, &value, &weight}) {
    lanes->clear();
  }
  x.clear();
  y.clear();
  clipped.clear();
}

void RimBand::reserve(std::size_t n) {
  for (auto* lanes : {&at_x, &at_y, &plane_x, &plane_y, &value, &weight}) lanes->reserve(n);
  if (has_jacobian) {
    for (auto* lanes : {&j00, &j01, &j10, &j11}) lanes->reserve(n);
  }
  x.reserve(n);
  y.reserve(n);
  clipped.reserve(n);
}

std::size_t RimBand::grow(std::size_t n) {
  const std::size_t first = size();
  const std::size_t end = first + n;
  for (auto* lanes : {&at_x, &at_y, &plane_x, &plane_y, &value}) lanes->resize(end);
  if (has_jacobian) {
    for (auto* lanes : {&j00, &j01, &j10, &j11}) lanes->resize(end);
  }
  weight.resize(end, 1.0F);
  x.resize(end);
  y.resize(end);
  clipped.resize(end, 0);
  return first;
}

void RimBand::set_ramp(
    std::vector<float>& lanes, std::size_t first, std::size_t n, double start, double step) {
  float* const to = lanes.data() + first;
  const int end = static_cast<int>(n);
  for (int k = 0; k < end; ++k) to[k] = static_cast<float>(start + static_cast<double>(k) * step);
}

void RimChunk::load(const RimBand& band, std::size_t first, std::size_t n, Work& w) {
  copy_lanes(band.at_x, first, n, w.dx);
  copy_lanes(band.at_y, first, n, w.dy);
  copy_lanes(band.plane_x, first, n, w.u);
  copy_lanes(band.plane_y, first, n, w.v);
  if (!band.has_jacobian) return;
  copy_lanes(band.j00, first, n, w.j00);
  copy_lanes(band.j01, first, n, w.j01);
  copy_lanes(band.j10, first, n, w.j10);
  copy_lanes(band.j11, first, n, w.j11);
}

/// One rim about (dx, dy) = 0: by the profile of vision/fit/edge_profile.h.
void RimChunk::add_rim(const RimVector& p, double radius, bool has_jacobian, Work& w) {
  constexpr float kTinyRadius = 1e-6F;
  constexpr auto kReach = static_cast<float>(kEdgeReach);
  constexpr float kDensity = 0.3989422804F;  // 1 / sqrt(2 pi)
  const auto r0 = static_cast<float>(radius);
  const auto sigma = static_cast<float>(p[kSigma]);
  const float per_sigma = 1 / sigma;
  const float per_sigma2 = per_sigma * per_sigma;
  const float cumulant = -per_sigma2 * per_sigma2 / (120 * 24);
  const auto oval = static_cast<float>(p[kOval]);
  const auto diagonal = static_cast<float>(2 * p[kOvalDiagonal]);
  if (has_jacobian) {
    for (std::size_t i = 0; i < kSize; ++i) {
      const float r = std::max(std::sqrt(w.dx[i] * w.dx[i] + w.dy[i] * w.dy[i]), kTinyRadius);
      const float nx = w.dx[i] / r;
      const float ny = w.dy[i] / r;
      const float mx = w.j00[i] * nx + w.j10[i] * ny;
      const float my = w.j01[i] * nx + w.j11[i] * ny;
      w.per_unit[i] = 1 / std::max(std::sqrt(mx * mx + my * my), kTinyRadius);
      w.nx[i] = nx;
      w.ny[i] = ny;
      w.distance[i] =
          (r0 * (1 + oval * (nx * nx - ny * ny) + diagonal * nx * ny) - r) * w.per_unit[i];
      // The normal in the picture goes by these for a while.
      w.d_distance[i] = mx * w.per_unit[i];
      w.d_sigma[i] = my * w.per_unit[i];
    }
  } else {
    for (std::size_t i = 0; i < kSize; ++i) {
      const float r = std::max(std::sqrt(w.dx[i] * w.dx[i] + w.dy[i] * w.dy[i]), kTinyRadius);
      const float nx = w.dx[i] / r;
      const float ny = w.dy[i] / r;
      w.per_unit[i] = 1;
      w.nx[i] = nx;
      w.ny[i] = ny;
      w.distance[i] = r0 * (1 + oval * (nx * nx - ny * ny) + diagonal * nx * ny) - r;
      w.d_distance[i] = nx;
      w.d_sigma[i] = ny;
    }
  }
  for (std::size_t i = 0; i < kSize; ++i) {
    const float distance = w.distance[i];
    const float per_radius = 1 / (r0 * w.per_unit[i]);
    const float bend = 0.5F * sigma * per_radius;
    const float t = std::min(std::max(distance * per_sigma - bend, -kReach), kReach);
    const float nx2 = w.d_distance[i] * w.d_distance[i];
    const float ny2 = w.d_sigma[i] * w.d_sigma[i];
    const float q = cumulant * (nx2 * nx2 + ny2 * ny2);
    const float t2 = t * t;
    const float exponential = power_of_two(-0.5F * std::numbers::log2e_v<float> * t2);
    const float tail = exponential * tail_factor(std::abs(t));
    const float phi = kDensity * exponential;
    const float cdf = t > 0 ? 1 - tail : tail;
    const float he3_phi = t * (t2 - 3) * phi;
    const float d_t = phi + q * (t2 * (t2 - 6) + 3) * phi;
    w.share[i] = cdf - q * he3_phi;
    w.d_distance[i] = d_t * per_sigma;
    w.d_sigma[i] = 4 * q * per_sigma * he3_phi - d_t * (distance * per_sigma2 + 0.5F * per_radius);
    w.d_radius[i] = d_t * bend * per_radius;
  }
}

void RimChunk::evaluate(const RimBand& band,
                        std::size_t first_pixel,
                        const RimVector& p,
                        const RimFreedom& freedom,
                        Want want) {
  first = first_pixel;
  n = std::min(kSize, band.size() - first);
  Work w;
  load(band, first, n, w);
  const auto light_x = static_cast<float>(p[kLightX]);
  const auto light_y = static_cast<float>(p[kLightY]);
  const auto ground = static_cast<float>(p[kLevel]);
  const auto step = static_cast<float>(p[kContrast]);
  const auto step_x = static_cast<float>(p[kContrastX]);
  const auto step_y = static_cast<float>(p[kContrastY]);
  const auto center_x = static_cast<float>(p[kCenterX]);
  const auto center_y = static_cast<float>(p[kCenterY]);
  const bool has_gradient = want == Want::Gradient;
  for (std::size_t i = 0; i < kSize; ++i) {
    w.dx[i] -= center_x;
    w.dy[i] -= center_y;
  }
  add_rim(p, p[kRadius], band.has_jacobian, w);
  const auto radius = static_cast<float>(p[kRadius]);
  for (std::size_t i = 0; i < kSize; ++i) {
    const float light = 1 + w.u[i] * light_x + w.v[i] * light_y;
    w.contrast[i] = light * step + w.u[i] * step_x + w.v[i] * step_y;
    level[i] = light * ground + w.contrast[i] * w.share[i];
    share[i] = w.share[i];
    distance_px[i] = w.distance[i];
  }
  if (has_gradient) {
    for (std::size_t i = 0; i < kSize; ++i) {
      const float d = w.contrast[i] * w.d_distance[i] * w.per_unit[i];
      gradient[kCenterX][i] = d * w.nx[i];
      gradient[kCenterY][i] = d * w.ny[i];
      gradient[kRadius][i] = d + w.contrast[i] * w.d_radius[i] * w.per_unit[i];
      gradient[kSigma][i] = w.contrast[i] * w.d_sigma[i];
    }
    for (std::size_t i = 0; freedom.is_oval && i < kSize; ++i) {
      const float d = w.contrast[i] * w.d_distance[i] * w.per_unit[i] * radius;
      gradient[kOval][i] = d * (w.nx[i] * w.nx[i] - w.ny[i] * w.ny[i]);
      gradient[kOvalDiagonal][i] = 2 * d * w.nx[i] * w.ny[i];
    }
  }
  if (freedom.is_ring) {
    const auto hole = static_cast<float>(p[kHole]);
    const auto hole_x = static_cast<float>(p[kHoleX]);
    const auto hole_y = static_cast<float>(p[kHoleY]);
    const auto inner_radius = static_cast<float>(p[kInnerRadius]);
    for (std::size_t i = 0; i < kSize; ++i) {
      w.dx[i] -= hole_x;
      w.dy[i] -= hole_y;
    }
    add_rim(p, p[kInnerRadius], band.has_jacobian, w);
    for (std::size_t i = 0; i < kSize; ++i) {
      const float light = 1 + w.u[i] * light_x + w.v[i] * light_y;
      const float gain = light * hole - w.contrast[i];
      inner_px[i] = w.distance[i];
      share[i] -= w.share[i];
      level[i] += gain * w.share[i];
      w.contrast[i] = gain;
      gradient[kHole][i] = light * w.share[i];
    }
    for (std::size_t i = 0; has_gradient && i < kSize; ++i) {
      const float d = w.contrast[i] * w.d_distance[i] * w.per_unit[i];
      gradient[kHoleX][i] = d * w.nx[i];
      gradient[kHoleY][i] = d * w.ny[i];
      gradient[kCenterX][i] += d * w.nx[i];
      gradient[kCenterY][i] += d * w.ny[i];
      gradient[kInnerRadius][i] = d + w.contrast[i] * w.d_radius[i] * w.per_unit[i];
      gradient[kSigma][i] += w.contrast[i] * w.d_sigma[i];
    }
    for (std::size_t i = 0; has_gradient && freedom.is_oval && i < kSize; ++i) {
      const float d = w.contrast[i] * w.d_distance[i] * w.per_unit[i] * inner_radius;
      gradient[kOval][i] += d * (w.nx[i] * w.nx[i] - w.ny[i] * w.ny[i]);
      gradient[kOvalDiagonal][i] += 2 * d * w.nx[i] * w.ny[i];
    }
  }
  if (!has_gradient) return;
  for (std::size_t i = 0; i < kSize; ++i) {
    const float light = 1 + w.u[i] * light_x + w.v[i] * light_y;
    const float lit = (level[i] - share[i] * (w.u[i] * step_x + w.v[i] * step_y)) / light;
    gradient[kLevel][i] = light;
    gradient[kLightX][i] = lit * w.u[i];
    gradient[kLightY][i] = lit * w.v[i];
    gradient[kContrast][i] = light * share[i];
  }
  for (std::size_t i = 0; freedom.has_own_slope && i < kSize; ++i) {
    gradient[kContrastX][i] = share[i] * w.u[i];
    gradient[kContrastY][i] = share[i] * w.v[i];
  }
}

void RimChunk::weigh(const RimBand& band) {
  Lanes weight{};
  copy_lanes(band.value, first, n, residual);
  copy_lanes(band.weight, first, n, weight);
  std::fill(weight.begin() + static_cast<std::ptrdiff_t>(n), weight.end(), 0.0F);
  for (std::size_t i = 0; i < kSize; ++i) {
    residual[i] = level[i] - residual[i];
    cost[i] = residual[i] * residual[i] * weight[i];
  }
  for (std::size_t i = 0; i < kSize; ++i) root_weight[i] = std::sqrt(weight[i]);
}

RimPlaces rim_places(const RimBand& band, const RimVector& p) {
  constexpr float kTiny = 1e-6F;
  constexpr std::array terms = {static_cast<float>(kTurnTerms[0]),
                                static_cast<float>(kTurnTerms[1]),
                                static_cast<float>(kTurnTerms[2]),
                                static_cast<float>(kTurnTerms[3])};
  const auto n = static_cast<int>(band.size());
  RimPlaces places;
  places.distance_px.resize(band.size());
  places.turn.resize(band.size());
  const auto center_x = static_cast<float>(p[kCenterX]);
  const auto center_y = static_cast<float>(p[kCenterY]);
  const auto radius = static_cast<float>(p[kRadius]);
  const float* const at_x = band.at_x.data();
  const float* const at_y = band.at_y.data();
  float* const distance_px = places.distance_px.data();
  float* const turn = places.turn.data();
  for (int i = 0; i < n; ++i) {
    const float x = at_x[i] - center_x;
    const float y = at_y[i] - center_y;
    distance_px[i] = radius - std::sqrt(x * x + y * y);
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float t = std::min(ax, ay) / std::max(std::max(ax, ay), kTiny);
    const float t2 = t * t;
    const float first = t * (terms[0] + t2 * (terms[1] + t2 * (terms[2] + t2 * terms[3])));
    const float quarter = ay > ax ? 0.25F - first : first;
    const float half = x < 0 ? 0.5F - quarter : quarter;
    turn[i] = y < 0 ? 1 - half : half;
  }
  if (!band.has_jacobian) return places;
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float x = at_x[i] - center_x;
    const float y = at_y[i] - center_y;
    const float mx = band.j00[k] * x + band.j10[k] * y;
    const float my = band.j01[k] * x + band.j11[k] * y;
    const float r = std::max(std::sqrt(x * x + y * y), kTiny);
    distance_px[i] *= r / std::max(std::sqrt(mx * mx + my * my), kTiny * r);
  }
  return places;
}

RimBandValues band_values(const RimBand& band, const RimVector& p, bool is_ring) {
  RimBandValues values;
  values.level.resize(band.size());
  values.share.resize(band.size());
  values.distance_px.resize(band.size());
  RimFreedom freedom;
  freedom.is_ring = is_ring;
  RimChunk chunk;
  for (std::size_t first = 0; first < band.size(); first += kSize) {
    chunk.evaluate(band, first, p, freedom, RimChunk::Want::Values);
    const auto at = static_cast<std::ptrdiff_t>(first);
    std::copy_n(chunk.level.begin(), chunk.n, values.level.begin() + at);
    std::copy_n(chunk.share.begin(), chunk.n, values.share.begin() + at);
    std::copy_n(chunk.distance_px.begin(), chunk.n, values.distance_px.begin() + at);
  }
  return values;
}

}  // namespace panelcal::internal
