// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode/setting.h"

#include <algorithm>

#include "calib/correction/tolerance.h"

namespace panelcal {
namespace {

template <class T>
void fill_setting(std::optional<T>& known, const std::optional<T>& said) {
  if (!known) known = said;
}

void fill_setting(GcodeWork& known, const GcodeWork& said) {
  fill_setting(known.drill_z, said.drill_z);
  fill_setting(known.rout_z, said.rout_z);
  fill_setting(known.peck, said.peck);
  fill_setting(known.infeed, said.infeed);
  fill_setting(known.retract, said.retract);
  fill_setting(known.feed, said.feed);
  fill_setting(known.speed, said.speed);
}

}  // namespace

GcodeWork GcodeSetting::work_of(const Tool& tool) const {
  GcodeWork work;
  work.infeed = tool.infeed;
  work.retract = tool.retract;
  work.speed = tool.speed;
  const auto numbered =
      std::ranges::find_if(tools, [&](const GcodeTool& row) { return row.number == tool.number; });
  if (numbered != tools.end()) fill_setting(work, numbered->work);
  const auto sized = std::ranges::find_if(tools, [&](const GcodeTool& row) {
    return !row.number && tool.diameter && row.drill && is_same_drill(*row.drill, *tool.diameter);
  });
  if (sized != tools.end()) fill_setting(work, sized->work);
  fill_setting(work, usual);
  return work;
}

}  // namespace panelcal
