// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace panelcal::bench {

/// Rims that are not round, and targets and boards that are not flat: found or refused, and how the
/// errors compare with the covariance. One row a kind, those whose name contains `only`.
void print_rims(int n, std::uint64_t seed, const std::string& only);

}  // namespace panelcal::bench
