// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

/// Prints milliseconds of one thread, panelcal beside SimpleBlobDetector in the same run.
void print_speed(const Mark& mark, std::uint64_t seed);

}  // namespace panelcal::bench
