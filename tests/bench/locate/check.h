// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panelcal::bench {

/// Compares the bounds with what is known otherwise, and prints it. False if something is wrong.
bool check_bounds(std::uint64_t seed);

}  // namespace panelcal::bench
