// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

namespace panelcal {

struct LedgerOptions {
  /// Longest wait for another program. Longer than a colleague's query takes, shorter than
  /// anybody's patience.
  std::chrono::milliseconds busy_timeout{10000};
  /// Number of the newest entries whose hashes are checked when the ledger is opened; `verify`
  /// checks all.
  std::size_t n_checked = 64;
};

}  // namespace panelcal
