// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/stated_clock.h"

#include "machine/job/text_variables.h"

namespace panelcal {

Expected<Clock> stated_clock(const std::string& text) {
  if (text.empty()) return system_clock();
  std::string bare = text;
  if (bare.ends_with('Z')) bare.pop_back();
  PANELCAL_TRY(const std::string time, wall_time(bare, {}));
  return fixed_clock(*from_iso_8601(time + "Z"));
}

}  // namespace panelcal
