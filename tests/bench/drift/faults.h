// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/bench/drift/detector.h"

namespace panelcal::bench {

/// The faults and the methods of a channel's table.
std::vector<Fault> faults(Channel channel);
std::vector<Method> methods(Channel channel);

/// The fault's first night in a year: from 60 to 119.
int onset_of(std::uint64_t seed);

}  // namespace panelcal::bench
