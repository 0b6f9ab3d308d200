// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/ledger/database/sqlite.h"
#include "calib/ledger/entry/entry.h"
#include "calib/ledger/entry/filter.h"

// Not installed: looking entries up.
namespace panelcal::internal {

/// The entry of that id, checked against its hash.
///
/// Fails  ledger-entry-unknown; ledger-corrupt
Expected<LedgerEntry> entry_of(SqliteConnection& connection, std::int64_t id);

/// The ids that the filter lets pass, in their order.
Expected<std::vector<std::int64_t>> ids_of(SqliteConnection& connection,
                                           const LedgerFilter& filter);

/// The installed entry that is in force.
Expected<std::optional<std::int64_t>> id_in_force(SqliteConnection& connection,
                                                  const LedgerKey& key);
Expected<std::vector<std::int64_t>> ids_in_force(SqliteConnection& connection,
                                                 std::string_view machine);

}  // namespace panelcal::internal
