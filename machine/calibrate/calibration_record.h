// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/ledger/ledger.h"
#include "machine/config/machine_config.h"
#include "machine/config/machine_name.h"

namespace panelcal {

/// Operator, time and reason of a calibration: a ledger's entry without the numbers.
struct RecordWords {
  std::chrono::sys_seconds date{};  ///< UTC
  LedgerVerdict verdict = LedgerVerdict::Measured;
  std::string reason;    ///< of the verdict
  std::string asked_by;  ///< a user, a timer
  std::string software;  ///< "panelcal 0.1.0"
  std::optional<double> temperature_degC = std::nullopt;
};

/// A record that says who, when and why, of nothing yet.
LedgerRecord record_of(LedgerKey key, const RecordWords& words);

/// A draft of such a record, of what is done with the machine that a machine.toml describes: the
/// file is its first input.
///
/// Fails  file-unreadable
Expected<LedgerDraft> draft_of(const MachineConfig& config,
                               LedgerKey key,
                               const RecordWords& words);

/// A file as the ledger notes it, by its name without the folder.
///
/// Fails  file-unreadable
Expected<LedgerInput> input_of(const std::filesystem::path& file,
                               std::size_t max_bytes = kMaxCalibrationBytes);
/// The same of all files that have a name.
Expected<void> add_inputs(std::initializer_list<std::filesystem::path> files,
                          std::vector<LedgerInput>& inputs);

/// Notes the ledger's head in a draft of a calibration that has a file: held against the ledger
/// later, the file tells that entries were deleted.
///
/// In     draft: with the file's text as its result
/// Fails  what the ledger reports
Expected<void> note_head(const Ledger& ledger, LedgerDraft& draft);

/// A calibration's text that is in no ledger, for a file: with the head of the machine's ledger if
/// there is one.
///
/// Fails  what the ledger reports
Expected<std::string> text_with_head(const MachineConfig& config, std::string text);

/// All of a key that were ever installed, in their order.
Expected<std::vector<LedgerEntry>> installed_entries(const Ledger& ledger, const LedgerKey& key);

/// True if a calibration of `date`, which is not one of the installed ones, was made since there is
/// a ledger: the first installation may have been cut off before it replaced what was there without
/// one.
bool is_since_the_ledger(const std::vector<LedgerEntry>& installed,
                         const LedgerEntry& in_force,
                         std::chrono::sys_seconds date);

/// ", for NAME, by SOFTWARE", as far as they are known: the end of a calibration's provenance.
std::string by_whom(const RecordWords& words);

}  // namespace panelcal
