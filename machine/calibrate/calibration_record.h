// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "calib/spindle/calibration_file.h"
#include "machine/calibrate/spindle/camera_run.h"
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
Expected<LedgerInput> input_of(const std::filesystem::path& file);

/// Notes the ledger's head in a draft of a calibration that has a file: held against the ledger
/// later, the file tells that entries were deleted. Drafts of other kinds stay as they are.
///
/// In     draft: of such a kind, with the file's text as its result
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

/// "spindle 1 station 1", as the ledger's subject.
std::string subject(SpindleAt at);

/// The ledger's key of the offset that [spindle] names. A machine without a name is "machine".
LedgerKey spindle_camera_key(const MachineConfig& config);

/// The run's offset as a calibration file of this one spindle.
SpindleCalibration spindle_camera_calibration(const MachineConfig& config,
                                              const SpindleCameraRun& run,
                                              const RecordWords& words);

/// The same for the ledger: parameters offset_x and offset_y in mm with their covariance; the file
/// as the result, in whose "quality" is the rest; machine.toml and the camera's calibration, which
/// the offset goes with, as inputs.
///
/// Fails  file-unreadable (an input is gone); calibration-invalid (a fit that makes no file)
Expected<LedgerDraft> spindle_camera_draft(const MachineConfig& config,
                                           const SpindleCameraRun& run,
                                           const RecordWords& words);

/// Makes [spindle] calibration's file say what is in force in the ledger, of all spindles of this
/// machine. One that already does is left alone, so this also mends an installation that was
/// interrupted between the ledger and the file.
///
/// With one spindle the file is its entry's result, byte for byte; with several the offsets are put
/// together, in their order. Spindles that only the file has are kept.
///
/// Out    whether a file was written; false where the ledger has nothing in force
/// Fails  config-value (no [spindle] calibration); calibration-invalid (a result is not valid);
///        what the ledger reports; device-write
/// See    tests/machine/calibrate/calibration_record_test.cc
Expected<bool> install_spindle_camera(const MachineConfig& config, const Ledger& ledger);

/// Spindles of which [spindle] calibration's file has an offset past the ledger: another one than
/// what is in force, and none that was installed before. An operator put it there by hand
/// (`calibrate -o`), and to write the file again would lose it. None where the file is not there or
/// is damaged, and none of the time before the first installation.
Expected<std::vector<SpindleAt>> spindles_by_hand(const MachineConfig& config,
                                                  const Ledger& ledger);

}  // namespace panelcal
