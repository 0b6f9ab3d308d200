// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "vision/locate/locate.h"

namespace panelcal {

/// Picture and tool of a located target, and the detail of its output.
struct LocatedTarget {
  std::string image;              ///< as the command line names it
  int tool = 0;                   ///< number of the vision tool
  bool lists_candidates = false;  ///< also if the target was found
};

/// The output of `panelcal locate` for one picture: a JSON object and a line end.
///
/// See    docs/formats/located_targets.md; tests/tools/locate/located_json_test.cc
std::string located_json(const LocatedTarget& located, const Detection& detection);

}  // namespace panelcal
