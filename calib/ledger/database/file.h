// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/database/options.h"
#include "calib/ledger/database/sqlite.h"
#include "calib/ledger/entry/entry.h"

// Not installed: the file that a ledger is, apart from what stands in it.
namespace panelcal::internal {

/// Makes an empty ledger that appears whole under its name, unless there is a file by then.
///
/// Fails  device-write
Expected<void> create_ledger_file(const std::filesystem::path& path);

/// Opens a ledger and makes sure that it is one, of this version, and undamaged as far as can be
/// told without reading every hash.
///
/// Fails  as Ledger::open
Expected<std::unique_ptr<SqliteConnection>> open_ledger_file(const std::filesystem::path& path,
                                                             SqliteConnection::Mode mode,
                                                             const LedgerOptions& options);

/// Checks that the file is a ledger of this version; cheap enough for every transaction.
Expected<void> check_version(SqliteConnection& connection);

/// Moves a file and what SQLite keeps beside it to a name that nothing has, and says which.
///
/// Fails  device-write
Expected<std::filesystem::path> move_aside(const std::filesystem::path& path,
                                           const std::string& suffix);

}  // namespace panelcal::internal
