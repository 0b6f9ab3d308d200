// SPDX-License-Identifier: Apache-2.0
#include "machine/job/spindle_age.h"

#include "calib/base/clock.h"
#include "machine/job/text_variables.h"

namespace panelcal {
namespace {

/// A moment as the clock on the wall had it.
Expected<std::chrono::sys_seconds> on_wall(std::chrono::sys_seconds utc) {
  PANELCAL_TRY(const std::string text, wall_time("", utc));
  return *from_iso_8601(text + "Z");
}

}  // namespace

Expected<void> age_offset(MachineConfig& config, std::chrono::sys_seconds now_utc) {
  if (!config.offset_date) return {};
  // By UTC where that is known: an hour of autumn is on the wall twice.
  if (config.offset_date->is_utc) return age_spindle_camera(config, now_utc);
  PANELCAL_TRY(const std::chrono::sys_seconds now, on_wall(now_utc));
  return age_spindle_camera(config, now);
}

Expected<void> age_offset(MachineConfig& config,
                          const std::string& clock,
                          std::chrono::sys_seconds now_utc) {
  PANELCAL_TRY(const std::string time, wall_time(clock, now_utc));
  if (!config.offset_date) return {};
  if (clock.empty()) return age_offset(config, now_utc);
  OffsetDate& date = *config.offset_date;
  if (date.is_utc) {
    PANELCAL_TRY(date.date, on_wall(date.date));
    date.is_utc = false;
  }
  return age_spindle_camera(config, *from_iso_8601(time + "Z"));
}

}  // namespace panelcal
