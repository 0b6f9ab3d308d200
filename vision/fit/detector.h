// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "calib/camera/mapping.h"
#include "vision/fit/detection.h"
#include "vision/fit/judgement.h"
#include "vision/fit/search_area.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"

// Not installed.
namespace panelcal::internal {

/// A candidate after its fit, and what speaks against it.
struct FittedCandidate {
  Judgement judgement;
  TargetFit fit;

  bool is_good() const { return judgement.verdict == Verdict::Good; }
};

/// The input of every detector.
struct DetectorInput {
  const Image& image;
  const Target& target;  ///< validated
  const CameraMapping* mapping = nullptr;
  const LocateOptions& options;  ///< validated
  SearchArea area;

  /// Grey levels.
  double min_contrast() const { return options.min_contrast * image.full_scale(); }
  /// Of the target's levels against its surroundings'.
  double sign() const { return target.polarity == Polarity::Dark ? -1 : 1; }
};

/// The places of one picture that are fitted at most: rows of equal pads around round targets,
/// squares and crosses; of what is slower to fit, or stands alone, fewer.
constexpr std::size_t kMaxFitted = 24;
constexpr std::size_t kMaxFittedSlow = 8;

/// A detector of each family of shapes, by detect() of vision/fit/pipeline.h.
using Detector = std::vector<FittedCandidate>(const DetectorInput& input);
#define PANELCAL_SHAPE(shape, word, size, detector, max_fitted) Detector detector;
#include "vision/fit/shapes.def"

/// detect_rims() with another limit to how many rims are fitted, the best seen ones.
std::vector<FittedCandidate> detect_rims(const DetectorInput& input, std::size_t max_fitted);

}  // namespace panelcal::internal
