// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {
inline constexpr const char* kVersion = PANELCAL_VERSION;
}  // namespace panelcal
