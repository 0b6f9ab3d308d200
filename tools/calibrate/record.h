// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/config/machine_config.h"
#include "machine/nightly/record/night_lock.h"
#include "tools/cli/options/options.h"

namespace panelcal::calibrate {

/// Date, software, who and why, as the command line has them.
///
/// Fails  usage
Expected<RecordWords> words_of(const CalibrateOptions& options);

/// A file as the ledger notes it, by its name without the folder.
///
/// Fails  file-unreadable
Expected<LedgerInput> input_of(const std::filesystem::path& file, std::size_t most_bytes);

/// The ledger that --install records in, opened before anything is measured, and the machine's
/// lock, which keeps the nightly run away meanwhile.
class Recorder {
 public:
  /// Without --install there is no ledger; the lock is taken if `drives` all the same.
  ///
  /// Fails  config-value (no [ledger] file); ledger-busy and what else the ledger reports
  static Expected<Recorder> open(const CalibrateOptions& options,
                                 const MachineConfig& config,
                                 std::chrono::sys_seconds date,
                                 bool drives);

  /// The calibration in force, byte for byte; empty where none is, and without --install.
  Expected<std::optional<std::string>> text_in_force(const LedgerKey& key) const;

  /// Records an entry, and writes what is in force to `file` from the ledger if the entry's verdict
  /// is that it is installed; an empty name writes nothing. The file notes the ledger's head.
  /// Returns the entry's number.
  ///
  /// Precondition: --install
  Expected<std::int64_t> record(LedgerDraft draft, const std::filesystem::path& file);

 private:
  std::optional<NightLock> lock_;
  std::optional<Ledger> ledger_;
};

/// The verdict of --install on what `refusal` (empty: nothing) speaks against.
void judge(const std::string& refusal, RecordWords& words);

/// The result in a line.
std::string verdict_line(const std::string& refusal, const std::optional<std::int64_t>& entry);

}  // namespace panelcal::calibrate
