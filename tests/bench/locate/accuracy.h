// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

struct AccuracyOptions {
  int n = 400;
  std::uint64_t seed = 1;
  bool with_peers = true;
  std::string dump;  ///< folder for pictures that were missed or grossly wrong; empty: none
};

/// Draws n pictures of 640 x 480, asks every method about each and prints the table.
void print_accuracy(const Condition& condition, const Mark& mark, const AccuracyOptions& options);

}  // namespace panelcal::bench
