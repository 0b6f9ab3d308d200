// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "calib/base/statistics/random.h"

namespace panelcal::fuzz {

/// Bytes that readers look at.
inline constexpr std::string_view kChangedBytes = "0123456789.,-+eE<>/\"'={}[]: \t\r\nXYn\xff\0";

/// A few bytes of an input changed, inserted or erased at random.
inline std::string changed(Random& random, std::string bytes) {
  const int n_changes = 1 + static_cast<int>(random.uniform(0, 4));
  for (int i = 0; i < n_changes; ++i) {
    const auto at = static_cast<std::size_t>(random.uniform(0, static_cast<double>(bytes.size())));
    const auto byte =
        static_cast<std::size_t>(random.uniform(0, static_cast<double>(kChangedBytes.size())));
    const double kind = random.uniform();
    if (kind < 0.6) {
      bytes[at] = kChangedBytes[byte];
    } else if (kind < 0.8) {
      bytes.insert(at, 1, kChangedBytes[byte]);
    } else {
      bytes.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 9)));
    }
    if (bytes.empty()) break;
  }
  return bytes;
}

}  // namespace panelcal::fuzz
