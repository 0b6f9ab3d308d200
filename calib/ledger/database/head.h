// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace panelcal {

/// The newest entry, 0 and "" of an empty ledger. Noted elsewhere (a report), it proves later that
/// nothing was cut off or rewritten up to there; the ledger alone cannot prove that.
struct LedgerHead {
  std::int64_t id = 0;
  std::string hash;

  friend bool operator==(const LedgerHead&, const LedgerHead&) = default;
};

}  // namespace panelcal
