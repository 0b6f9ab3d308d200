// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal::internal {

/// Lengths, angles and so on that no machine exceeds: what is larger has the wrong unit.
inline constexpr double kMaxPlace_mm = 1e5;

}  // namespace panelcal::internal
