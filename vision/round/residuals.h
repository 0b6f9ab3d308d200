// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/round/fit.h"
#include "vision/round/model/window.h"

namespace panelcal::internal {

/// The residuals of a fit, pixel by pixel of its window; 0 where there is nothing to
/// compare.
struct RimResiduals {
  enum Kind : std::uint8_t {
    kNowhere = 0,  ///< not in the window, or clipped
    kZone = 1,     ///< plus the zone's number: a flat pixel
    kBand = 8,     ///< plus the zone on whose side of the rim it is
  };

  int width = 0;
  int height = 0;
  std::vector<float> values;  ///< seen minus model, grey levels
  std::vector<std::uint8_t> kinds;
  RimBandValues band;  ///< the model in the window's band
};

/// In     window: collected about the parameters with stride 1
RimResiduals residuals_of(const RimWindow& window, const RimVector& parameters);

/// The noise of a picture about a target.
struct RimNoiseEstimate {
  RimNoise total;            ///< sigma of all that is left, per zone
  double white = 0;          ///< sigma of what differs from pixel to pixel around the target
  bool is_textured = false;  ///< the target or its surroundings are correlated
  double rim_ratio = 1;      ///< variance in the band over what the zones predict
  double rim_sigma = 0;      ///< in the band
  int n_band = 0;
};

/// No sigma is below that of rounding, nor below what models of edges leave of the contrast.
/// A portmanteau test on eight short lags tells whether there is texture.
///
/// In     contrast: of the target, grey levels, of any sign
/// Source Box and Pierce 1970
RimNoiseEstimate estimate_noise(const RimWindow& window,
                                const RimResiduals& residuals,
                                double contrast);

/// The part of the rim that is seen: sectors whose own contrast is near that of the whole.
///
/// Sectors outside of the picture are not seen.
double visible_share(const RimWindow& window, const RimVector& parameters);

}  // namespace panelcal::internal
