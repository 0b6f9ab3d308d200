// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/ground_texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::internal {

double GroundTexture::far_variance() const {
  const double area = 4 * std::numbers::pi * rest.range_px * rest.range_px;
  return rest.white_sigma * rest.white_sigma + area * rest.sigma * rest.sigma;
}

double GroundTexture::reach_px() const {
  constexpr double kReachInRanges = 2.5;
  constexpr double kMinReach_px = 8;
  constexpr double kMaxReach_px = 20;
  return std::clamp(kReachInRanges * rest.range_px, kMinReach_px, kMaxReach_px);
}

std::optional<GroundTexture> ground_texture_of(const FlatResiduals& residuals) {
  GroundTexture texture;
  std::vector<float> left;
  texture.lines = texture_lines(residuals, left);
  if (const auto rest = texture_of({left, residuals.width, residuals.n})) {
    texture.rest = *rest;
    return texture;
  }
  if (texture.lines.empty()) return std::nullopt;
  // Nothing but waves: the rest is white.
  double square = 0;
  for (const float v : left) square += static_cast<double>(v) * static_cast<double>(v);
  texture.rest.white_sigma = std::sqrt(square / residuals.n);
  texture.rest.sigma = 0.02 * texture.rest.white_sigma;
  texture.rest.range_px = 4;
  return texture;
}

}  // namespace panelcal::internal
