// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace panelcal {

/// Tells the time; passed in, so that a recorded run replays bit for bit.
using Clock = std::function<std::chrono::sys_seconds()>;

Clock system_clock();
Clock fixed_clock(std::chrono::sys_seconds time);

/// `2026-11-21T08:37:38Z` (ISO 8601, UTC).
std::string iso_8601(std::chrono::sys_seconds time);

/// The time that iso_8601 would print as exactly this text; empty for any other text.
std::optional<std::chrono::sys_seconds> from_iso_8601(std::string_view text);

}  // namespace panelcal
