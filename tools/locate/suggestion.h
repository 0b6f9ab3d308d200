// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/units.h"
#include "vision/suggest/seen_mark.h"

namespace panelcal {

/// The marks of one picture.
struct PictureMarks {
  std::string image;  ///< as the command line names it
  std::vector<SeenMark> marks;
};

/// The output of `panelcal locate --suggest`: a list of what is in the pictures as comments, and a
/// [[vision.tool]] block for each of the most useful groups. As a whole it is TOML.
///
/// In     pixel: if known, sizes are given in mm
/// See    docs/formats/located_targets.md; tests/tools/locate/suggestion_test.cc
std::string suggestion_toml(const std::vector<PictureMarks>& pictures, std::optional<Length> pixel);

}  // namespace panelcal
