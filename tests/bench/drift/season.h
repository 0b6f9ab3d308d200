// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panelcal::bench {

/// Prints what the monitor of the nights, at its defaults, says of years with a season, the
/// temperature noted or not.
int print_season(int n_years, std::uint64_t seed);

}  // namespace panelcal::bench
