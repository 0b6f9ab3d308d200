// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/camera/mapping.h"
#include "vision/fit/detection.h"
#include "vision/fit/search_area.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"

namespace panelcal::internal {

/// A candidate after its fit, and what speaks against it.
struct FittedCandidate {
  enum class Verdict {
    Good,
    Unfit,     ///< surely there, but not the target asked for: wrong size, at the border
    Unlikely,  ///< too faint or too little like the target to be called one
  };

  Verdict verdict = Verdict::Unlikely;
  std::string reason;
  TargetFit fit;
};

/// The input of every detector.
struct DetectorInput {
  const Image& image;
  const Target& target;  ///< validated
  const CameraMapping* mapping = nullptr;
  const LocateOptions& options;  ///< validated
  SearchArea area;
};

/// The places of one picture that are fitted at most: rows of equal pads around round targets,
/// squares and crosses; of what is slower to fit, or stands alone, fewer.
constexpr std::size_t kMaxFitted = 24;
constexpr std::size_t kMaxFittedSlow = 8;

/// Finds every candidate in the searched area, fits and judges it; the order does not matter.
///
/// A candidate whose fit leaves the searched area is left out.
std::vector<FittedCandidate> detect_rims(const DetectorInput& input);  // Disc, Hole, Ring
/// The same with another limit to how many rims are fitted, the best seen ones.
std::vector<FittedCandidate> detect_rims(const DetectorInput& input, std::size_t max_fitted);
std::vector<FittedCandidate> detect_cells(const DetectorInput& input);  // Square, Diamond, Cross
std::vector<FittedCandidate> detect_slots(const DetectorInput& input);
std::vector<FittedCandidate> detect_dots(const DetectorInput& input);
std::vector<FittedCandidate> detect_templates(const DetectorInput& input);
std::vector<FittedCandidate> detect_tags(const DetectorInput& input);

}  // namespace panelcal::internal
