// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode_setting.h"

#include <algorithm>

#include "calib/correction/tolerance.h"

namespace panelcal {
namespace {

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
  const auto sized = std::ranges::find_if(tools, [&](const GcodeTool& row) {
    return !row.number && tool.diameter && row.drill && is_same_drill(*row.drill, *tool.diameter);
  });
  if (sized != tools.end()) fill(work, sized->work);
  fill(work, usual);
  return work;
}

}  // namespace panelcal
