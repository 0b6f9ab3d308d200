// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

namespace panelcal {

struct LedgerOptions {
  /// How long to wait for another program. Longer than a colleague's query takes, shorter than
  /// anybody's patience.
  std::chrono::milliseconds busy_timeout{10000};
  /// How many of the newest entries have their hashes checked when the ledger is opened; all of
  /// them take `verify`.
  std::size_t n_checked = 64;
};

}  // namespace panelcal
