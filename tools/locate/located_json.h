// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "tools/locate/suggestion.h"
#include "vision/locate/locate.h"

// Rows of `panelcal locate`, one a picture: docs/formats/located_targets.md.
namespace panelcal {

/// Picture and tool of a located target, and the detail of its output.
struct LocatedTarget {
  std::string image;              ///< as the command line names it
  int tool = 0;                   ///< number of the vision tool
  bool lists_candidates = false;  ///< also if the target was found
};

/// See    tests/tools/locate/located_json_test.cc
facts::Json located_row(const LocatedTarget& located, const Detection& detection);
/// The groups of marks of a picture.
///
/// See    tests/tools/locate/suggestion_test.cc
facts::Json suggested_row(const PictureMarks& picture);

}  // namespace panelcal
