// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/polygon/fit.h"
#include "vision/tag/family.h"
#include "vision/tag/quads.h"
#include "vision/tag/reader.h"

namespace panelcal::internal {

/// A tag that was read, before its fit.
struct TagSighting {
  TagQuad quad;  ///< corners in the tag's order
  TagReading reading;
};

inline bool is_wanted(const DetectorInput& input, const TagReading& reading) {
  return input.target.tag_id.value_or(reading.id) == reading.id;
}

/// A tag after its fit.
struct TagFit {
  FitFrame fit_frame;
  TagReading reading;
  CellFit cells;  ///< not converged: nothing more is known than what the quad says
  TargetFit target;
};

/// Fits all edges of the tag's known pattern to the picture.
///
/// The pattern's pose is a homography (eight numbers) in the fit frame, found together with the
/// light's two planes and the blur; every edge between a black and a white cell counts, of which
/// the frame's outline is a small part. The centre is where the tag's middle is seen: that is where
/// its diagonals meet, not the mean of the corners. A tag whose id is not asked for is not fitted.
///
/// Cost   25 to 50 ms for a tag of 120 px: 20,000 pixels see an edge
/// See    tests/vision/tag/detector_test.cc
TagFit fit_tag(const DetectorInput& input, const TagFamily& family, const TagSighting& sighting);

Judgement judge_tag(const DetectorInput& input, const TagFamily& family, const TagFit& fit);

}  // namespace panelcal::internal
