// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

struct FalseOptions {
  int n = 10'000;
  std::uint64_t seed = 1;
  bool with_peers = true;
  std::string dump;  ///< folder for pictures where panelcal found what is not there; empty: none
};

/// Draws n pictures without the mark and prints in how many each method found it.
void print_false_rate(const Mark& mark, const FalseOptions& options);

}  // namespace panelcal::bench
