// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

namespace panelcal::serve {

struct ConnectionLimits {
  std::size_t head_bytes = 8192;  ///< of request line and headers together
  std::chrono::milliseconds head_time{10'000};
  std::chrono::milliseconds idle_time{15'000};  ///< between two requests
  /// For what is sent or received beyond it, a second a piece of this size: slower ones are
  /// dropped.
  std::chrono::milliseconds transfer_time{10'000};
  std::size_t slowest_bytes_s = 65536;
};

}  // namespace panelcal::serve
