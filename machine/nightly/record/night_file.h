// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"

// Not installed: parts of the calibrations whose file is their entry's result, byte for byte.
namespace panelcal::internal {

/// The file as it should be; empty where nothing is in force.
Expected<std::optional<std::string>> text_in_force(const Ledger& ledger, const LedgerKey& key);

/// True if the file has the calibration in force, or if none is in force.
Expected<bool> says_what_is_in_force(const Ledger& ledger,
                                     const LedgerKey& key,
                                     const std::filesystem::path& file);

/// Date of a calibration file's bytes; empty for a damaged one.
using DateOfBytes = std::function<std::optional<std::chrono::sys_seconds>(const std::string&)>;

/// That of a reader of such files.
///
/// In     parse: of the bytes, and the file's name in messages
template <class Parse>
DateOfBytes date_by(const Parse& parse) {
  return [parse](const std::string& bytes) -> std::optional<std::chrono::sys_seconds> {
    const auto calibration = parse(bytes, "");
    if (!calibration) return std::nullopt;
    return calibration->date;
  };
}

/// NightCalibration::by_hand: `words` if the file has what was put there past the ledger, which is
/// nothing that was ever installed, and nothing of the time before the first installation. A
/// damaged file is what the ledger is there for.
Expected<std::string> by_hand_in(const Ledger& ledger,
                                 const LedgerKey& key,
                                 const std::filesystem::path& file,
                                 std::string words,
                                 const DateOfBytes& date_of);

/// NightCalibration::install: writes the file if it does not say what is in force.
Expected<bool> write_what_is_in_force(const Ledger& ledger,
                                      const LedgerKey& key,
                                      const std::filesystem::path& file);

}  // namespace panelcal::internal
