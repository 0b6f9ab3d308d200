// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

namespace panelcal {

/// A picture of a mark at a lamp level.
struct LampSample {
  double level = 0;          ///< as the camera is told, in its own unit
  double contrast = 0;       ///< of the mark against its ground, as a share of full scale
  double clipped_share = 0;  ///< of the pixels, at the scale's end
};

struct LampLimits {
  double clipped_share = 0.001;  ///< more is clipping: glints are let pass, a mark is not
  double contrast = 0.1;         ///< less is no picture to measure in
  double worth = 0.02;           ///< relative gain of contrast for which it is not made brighter
};

struct LampLevel {
  double level = 0;
  double contrast = 0;
  /// The contrast still rose at the brightest level that was tried, and nothing clipped.
  bool is_at_end = false;
};

/// The level of best contrast that does not clip; of nearly equal ones the darkest, which is the
/// farthest from clipping when the board is brighter or the lamp has aged less.
///
/// Light only adds, so no level above the darkest one that clips is used, whatever it shows.
/// In     samples: any order, 3 levels or more; of one level the worst of each number counts
/// Out    empty: `reason` says why: too few levels, all clip, or no contrast without clipping
/// See    tests/calib/camera/lamp_level_test.cc
std::optional<LampLevel> best_lamp_level(std::span<const LampSample> samples,
                                         const LampLimits& limits,
                                         std::string* reason);

}  // namespace panelcal
