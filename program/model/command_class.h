// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace panelcal {

/// The class of a command; every one of the manual's belongs to one.
enum class CommandClass : std::uint8_t {
  Motion,
  Measurement,
  Correction,
  Depth,
  Tool,
  Setting,
  Event,
  Message,
};

std::string_view name(CommandClass command_class);

}  // namespace panelcal
