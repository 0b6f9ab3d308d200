// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/command_spindle.h"

#include <string>

#include "machine/devices/commands/external_program.h"
#include <fmt/format.h>

namespace panelcal {

Expected<void> CommandSpindle::drill(int tool) {
  if (drill_.empty()) {
    return failure({Code::NotSupported,
                    {"spindle", 0, 0},
                    "there is no command that drills a hole",
                    "[machine] drill_command"});
  }
  PANELCAL_CHECK(internal::run_program(
      internal::filled(drill_, {{"{tool}", fmt::format("{}", tool)}}), limit_));
  return {};
}

}  // namespace panelcal
