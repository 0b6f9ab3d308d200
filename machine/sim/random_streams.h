// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "calib/base/statistics/random.h"

namespace panelcal::internal {

/// The streams of random numbers. The values are part of what a seed means; do not renumber.
enum class RandomStream : std::uint64_t {
  Boards = 1,
  Noise = 2,
  Neighbors = 3,
  Probes = 4,
  Marks = 5,
  Debris = 6,
  Samples = 7,
  Nights = 8,
  Holes = 9,
};

/// The generator of one kind of thing at one measurement request, whatever was drawn before.
inline Random random_of(std::uint64_t seed, RandomStream stream, std::int64_t seq) {
  return Random(seed)
      .fork(static_cast<std::uint64_t>(stream))
      .fork(static_cast<std::uint64_t>(seq));
}

}  // namespace panelcal::internal
