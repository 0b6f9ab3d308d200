// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panelcal::bench {

/// Prints find_change as a detector beside the charts, and how well it dates what they caught.
int print_changes(int n_years, std::uint64_t seed);

}  // namespace panelcal::bench
