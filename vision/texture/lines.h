// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/texture/fit.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// One wave of a periodic texture such as glass weave: amplitude cos(wave . u + phase).
struct TextureLine {
  Eigen::Vector2d wave_per_px = Eigen::Vector2d::Zero();  ///< rad per px
  double amplitude = 0;                                   ///< grey levels
};

/// The waves that carry most of a texture, strongest first; none if it is not periodic.
///
/// Orthogonal matching pursuit on the residuals averaged over 4 x 4 px: the strongest peak of the
/// spectrum joins the waves, all amplitudes are fitted again, and so on while a wave explains a
/// noticeable part of what is left.
///
/// Out    the waves; `left`: the residuals without them
/// Source Pati, Rezaiifar and Krishnaprasad 1993
std::vector<TextureLine> texture_lines(const FlatResiduals& residuals, std::vector<float>& left);

}  // namespace panelcal::internal
