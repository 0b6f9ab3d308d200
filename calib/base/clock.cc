// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/base/clock.h"

#include <fmt/core.h>

namespace panelcal {

Clock system_clock() {
  return [] {
    return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  };
}

Clock fixed_clock(std::chrono::sys_seconds time) {
  return [time] { return time; };
}

std::string iso_8601(std::chrono::sys_seconds time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                     static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()),
                     clock.hours().count(),
                     clock.minutes().count(),
                     clock.seconds().count());
}

}  // namespace panelcal
