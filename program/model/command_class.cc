// SPDX-License-Identifier: Apache-2.0
#include "program/model/command_class.h"

#include <array>
#include <cstddef>

namespace panelcal {

std::string_view name(CommandClass command_class) {
  constexpr std::array<std::string_view, 8> kNames = {
      "motion", "measurement", "correction", "depth", "tool", "setting", "event", "message"};
  return kNames[static_cast<std::size_t>(command_class)];
}

}  // namespace panelcal
