// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

#include "calib/ledger/entry/entry.h"

namespace panelcal {

/// Selection of entries; an empty field does not restrict.
struct LedgerFilter {
  std::optional<std::string> machine;
  std::optional<LedgerKind> kind;
  std::optional<std::string> subject;
  std::optional<std::chrono::sys_seconds> since;  ///< not older than this
  std::optional<std::size_t> last;                ///< only this number of the newest
};

}  // namespace panelcal
