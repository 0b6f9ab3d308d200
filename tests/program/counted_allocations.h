// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panelcal::test {

/// Number of calls of operator new in this program so far; counted_allocations.cc replaces it.
/// Eigen's matrices of no fixed size take their memory elsewhere and are not counted.
std::int64_t n_allocations();

}  // namespace panelcal::test
