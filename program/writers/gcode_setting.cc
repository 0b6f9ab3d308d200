// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/writers/gcode_setting.h"

#include <algorithm>
#include <cmath>

namespace panelcal {
namespace {

/// As in [[diameter_page]]: what inches and millimetres with few decimals make of one drill.
bool has_diameter(const Tool& tool, const std::optional<Length>& drill) {
  return tool.diameter && drill && std::abs((*tool.diameter - *drill).in_um()) <= 0.5;
}

template <class T>
void fill(std::optional<T>& known, const std::optional<T>& said) {
  if (!known) known = said;
}

void fill(GcodeWork& known, const GcodeWork& said) {
  fill(known.drill_z, said.drill_z);
  fill(known.rout_z, said.rout_z);
  fill(known.peck, said.peck);
  fill(known.infeed, said.infeed);
  fill(known.retract, said.retract);
  fill(known.feed, said.feed);
  fill(known.speed, said.speed);
}

}  // namespace

GcodeWork GcodeSetting::work_of(const Tool& tool) const {
  GcodeWork work;
  work.infeed = tool.infeed;
  work.retract = tool.retract;
  work.speed = tool.speed;
  const auto numbered =
      std::ranges::find_if(tools, [&](const GcodeTool& row) { return row.number == tool.number; });
  if (numbered != tools.end()) fill(work, numbered->work);
  const auto sized = std::ranges::find_if(
      tools, [&](const GcodeTool& row) { return !row.number && has_diameter(tool, row.drill); });
  if (sized != tools.end()) fill(work, sized->work);
  fill(work, usual);
  return work;
}

}  // namespace panelcal
