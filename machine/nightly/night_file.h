// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/ledger.h"

// Not installed: parts of the calibrations whose file is their entry's result, byte for byte.
namespace panelcal::internal {

/// The file as it should be; empty where nothing is in force.
Expected<std::optional<std::string>> text_in_force(const Ledger& ledger, const LedgerKey& key);

/// Whether the file says what is in force; true where nothing is.
Expected<bool> says_what_is_in_force(const Ledger& ledger,
                                     const LedgerKey& key,
                                     const std::filesystem::path& file);

/// Whether a file's bytes were put there past the ledger: nothing that was ever installed, and
/// nothing of the time before the first installation.
///
/// In     date: of the calibration in it
Expected<bool> is_past_the_ledger(const Ledger& ledger,
                                  const LedgerKey& key,
                                  const std::string& bytes,
                                  std::chrono::sys_seconds date);

}  // namespace panelcal::internal
