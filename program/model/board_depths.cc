// SPDX-License-Identifier: Apache-2.0
#include "program/model/board_depths.h"

#include <algorithm>

#include "calib/correction/tolerance.h"

namespace panelcal {

std::optional<Length> BoardDepths::depth_of(int tool, std::optional<Length> diameter) const {
  const auto numbered =
      std::ranges::find_if(tools, [&](const ToolDepth& row) { return row.number == tool; });
  if (numbered != tools.end()) return numbered->depth;
  const auto sized = std::ranges::find_if(tools, [&](const ToolDepth& row) {
    return !row.number && diameter && row.drill && is_same_drill(*row.drill, *diameter);
  });
  return sized == tools.end() ? std::nullopt : std::optional(sized->depth);
}

}  // namespace panelcal
