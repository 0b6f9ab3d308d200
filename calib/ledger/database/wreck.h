// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

// Not installed.
namespace panelcal::internal {

/// True if a file that cannot be read as a ledger once was one: by the words that a ledger's schema
/// and entries leave in it. An empty file counts as one; a power cut may leave it.
///
/// Must not be asked of a database in use: closing the file would drop SQLite's locks.
bool is_wrecked_ledger(const std::filesystem::path& path);

}  // namespace panelcal::internal
