// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "vision/texture/fit.h"
#include "vision/texture/lines.h"

namespace panelcal::internal {

/// The texture around a target: waves, and an irregular rest.
struct GroundTexture {
  /// Far from the edges every n-th row and column is enough.
  static constexpr int kFarStride = 2;
  /// A second step of a fit is worth its time if the first was longer than this.
  static constexpr double kLongStep_px = 0.05;

  std::vector<TextureLine> lines;
  Texture rest;

  /// Far from the edges the rest counts as white noise of the strength that its slow part has.
  double far_variance() const;
  /// Distance from the edges to which ground is looked at pixel by pixel: ground that is farther
  /// says nothing of the texture there.
  double reach_px() const;
};

/// Fits it to the residuals of flat ground; empty if they have no texture.
std::optional<GroundTexture> ground_texture_of(const FlatResiduals& residuals);

}  // namespace panelcal::internal
