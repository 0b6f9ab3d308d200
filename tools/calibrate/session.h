// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/json/facts.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/nightly/record/night_lock.h"
#include "tools/cli/commands.h"

// The commands `panelcal calibrate KIND`: a night of one kind, by hand.
namespace panelcal::calibrate {

Diagnostic usage(std::string what,
                 std::string expected,
                 std::string_view command = "panelcal calibrate");

/// One call, whatever is calibrated: who asks and when, the machine, its lock, the ledger that
/// --install records in, and what became of the result.
class Session {
 public:
  /// Fails  usage (--clock); what reading machine.toml reports
  static Expected<Session> begin(const CalibrateOptions& options);

  const std::shared_ptr<MachineConfig>& config() const { return config_; }
  RecordWords& words() { return words_; }

  /// Checks that --install can write the file that [`section`] names.
  ///
  /// Fails  usage (--output as well); config-value
  Expected<void> check_install(std::string_view section, const std::filesystem::path& file) const;

  /// Keeps other runs away from the machine from now on, before its devices are opened, if it
  /// `drives` or records. A machine without a ledger has no nightly run.
  ///
  /// Fails  config-value (no [ledger] file to install into); ledger-busy; device-write
  Expected<void> lock(bool drives);
  /// Opens the ledger of --install, before anything is measured.
  ///
  /// Fails  what the ledger reports
  Expected<void> open_ledger();
  /// Null without --install.
  const Ledger* ledger() const { return ledger_ ? &*ledger_ : nullptr; }

  /// Writes a calibration to --output, or records it with its verdict and installs it from the
  /// ledger; --force overrules what is refused.
  ///
  /// In     refusal: what speaks against it; empty: nothing
  Expected<void> finish(LedgerDraft draft, const Calibration& kind, const std::string& refusal);

  /// Reason for which finish() refused it; empty: it was not refused.
  const std::string& refusal() const { return refusal_; }
  const std::optional<std::int64_t>& entry() const { return entry_; }

  /// The result in a line.
  std::string verdict_line() const;

  /// Writes the facts to --json and --report. Standard output has them in place of the text where
  /// one of the two says so.
  ///
  /// In     part: facts of this kind alone; share/schema/calibration.schema.json
  Answer answer(std::string text, facts::Json part, CommandContext& context) const;

 private:
  explicit Session(const CalibrateOptions& options) : options_(options) {}

  facts::Json document(facts::Json part, const Options& options) const;

  const CalibrateOptions& options_;
  RecordWords words_;
  std::shared_ptr<MachineConfig> config_;
  std::optional<NightLock> lock_;
  std::optional<Ledger> ledger_;
  LedgerRecord record_;    ///< of finish()
  std::string objection_;  ///< reasons against it, overruled or not
  std::string refusal_;
  std::optional<std::int64_t> entry_;
  bool is_in_ledger_alone_ = false;  ///< installed, and no file is named that would have it
};

}  // namespace panelcal::calibrate
