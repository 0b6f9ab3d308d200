// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/search_area.h"
#include "vision/polygon/model.h"

namespace panelcal::internal {

/// Sigma of the noise inside and outside of the pattern's targets, grey levels.
struct CellNoise {
  double outside = 1;
  double inside = 1;
  double rim = 0;         ///< of the residuals near the lines
  double rim_excess = 1;  ///< variance there over what the two predict, at least 1
};

/// The rectangle of the picture that holds the pixels; empty without any.
PixelBox box_of(const std::vector<CellPixel>& pixels);

/// From the residuals of the pixels not excluded; rim_excess needs weights of the same noise.
CellNoise noise_of(const CellModel& model,
                   const std::vector<CellPixel>& pixels,
                   const CellState& state,
                   double full_scale);

void set_weights(const CellModel& model,
                 const CellState& state,
                 const CellNoise& noise,
                 std::vector<CellPixel>& pixels);

/// Sets is_excluded on pixels that the model does not explain, and on their surroundings.
///
/// A pixel stands out by itself, or as a part of a blob: means over squares of pixels see debris
/// that is fainter than the noise of a pixel. Needs weights. Returns the part of the pixels near
/// lines that is excluded.
double exclude_strangers(const CellModel& model,
                         const CellState& state,
                         double full_scale,
                         std::vector<CellPixel>& pixels);

/// Correlation of model and picture near the lines, without the part of camera noise and what is
/// excluded.
///
/// In     reach_px: how far from the lines
double correlation_near(const CellModel& model,
                        const CellState& state,
                        const std::vector<CellPixel>& pixels,
                        double white_noise,
                        double reach_px);

/// Part of the targets' pixels that is not excluded: a pad with a hole, or half a pad, has less.
double intact_part(const CellModel& model,
                   const CellState& state,
                   const std::vector<CellPixel>& pixels);

/// Part of the outline that is there.
struct OutlineSeen {
  double visible = 0;          ///< part of the outline that looks like an edge of this contrast
  double outside_picture = 0;  ///< part of the outline without pixels
  double weakest_side = 1;     ///< of four sides: part of the one that is seen least
  double evenness = 1;         ///< of four sides: least step of level over the largest
};

/// Looks at the local contrast of every piece of the outline; excluded pixels count.
///
/// Pieces are so long that noise and texture leave a quarter of the contrast uncertain at most. One
/// that is still less certain shows nothing and is not seen: where the ground is as rough as the
/// target stands out, chance makes outlines, and such a fit does not count.
OutlineSeen outline_seen(const CellModel& model,
                         const CellState& state,
                         const std::vector<CellPixel>& pixels,
                         const CellNoise& noise);

}  // namespace panelcal::internal
