// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/clock.h"
#include "calib/base/expected.h"

namespace panelcal {

/// The clock on the wall, or one that stands still at the time of --clock.
///
/// In     text: empty, or UTC: "2026-11-21T02:00:00Z"; the Z may be left out
/// Fails  usage
Expected<Clock> stated_clock(const std::string& text);

}  // namespace panelcal
