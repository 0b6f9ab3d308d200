// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "calib/base/expected.h"
#include "calib/ledger/database/head.h"
#include "calib/ledger/database/sqlite.h"

// Not installed: the hashes that chain the entries.
namespace panelcal::internal {

/// The newest entry, whose own hash is right.
///
/// Fails  ledger-corrupt
Expected<LedgerHead> checked_head(SqliteConnection& connection);

/// Checks the chain and the contents of the newest n entries.
Expected<void> check_newest(SqliteConnection& connection, std::size_t n);

/// Checks the chain, the contents and the results of all.
Expected<LedgerHead> check_all(SqliteConnection& connection);

}  // namespace panelcal::internal
