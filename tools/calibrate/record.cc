// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/record.h"

#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "tools/calibrate/calibrate.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal::calibrate {

Expected<RecordWords> words_of(const CalibrateOptions& options) {
  RecordWords words;
  PANELCAL_TRY(words.date, time_of(options));
  words.reason = options.reason;
  // A name that only a ledger asks for.
  if (options.install) words.asked_by = asking_person(options.asked_by);
  words.software = std::string("panelcal ") + kVersion;
  return words;
}

Expected<LedgerInput> input_of(const std::filesystem::path& file, std::size_t most_bytes) {
  PANELCAL_TRY(const std::string bytes, read_file(file, most_bytes));
  return LedgerInput{file.filename().string(), sha256(bytes), bytes.size()};
}

Expected<Recorder> Recorder::open(const CalibrateOptions& options,
                                  const MachineConfig& config,
                                  std::chrono::sys_seconds date,
                                  bool drives) {
  Recorder recorder;
  if (options.install && config.ledger_file.empty()) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "there is no ledger to record what is installed",
                    "[ledger] file = \"NAME.ledger\""});
  }
  if (!config.ledger_file.empty() && (options.install || drives)) {
    PANELCAL_TRY(NightLock taken, NightLock::take(config.ledger_file, date));
    recorder.lock_.emplace(std::move(taken));
  }
  if (!options.install) return recorder;
  PANELCAL_TRY(recorder.ledger_, Ledger::open(config.ledger_file, [date] { return date; }));
  return recorder;
}

Expected<std::optional<std::string>> Recorder::text_in_force(const LedgerKey& key) const {
  std::optional<std::string> text;
  if (!ledger_) return text;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger_->in_force(key));
  if (!in_force) return text;
  PANELCAL_TRY(text, ledger_->result(in_force->id));
  return text;
}

Expected<std::int64_t> Recorder::record(LedgerDraft draft, const std::filesystem::path& file) {
  PANELCAL_CHECK(note_head(*ledger_, draft));
  // The ledger first: whatever happens then, it says which file should be there.
  PANELCAL_TRY(const LedgerEntry entry, ledger_->append(draft));
  if (entry.record.verdict == LedgerVerdict::Installed && !file.empty()) {
    PANELCAL_TRY(const std::string result, ledger_->result(entry.id));
    PANELCAL_CHECK(write_file(file, result));
  }
  return entry.id;
}

void judge(const std::string& refusal, RecordWords& words) {
  words.verdict = refusal.empty() ? LedgerVerdict::Installed : LedgerVerdict::Refused;
  if (!refusal.empty()) words.reason = refusal;
}

std::string verdict_line(const std::string& refusal, const std::optional<std::int64_t>& entry) {
  const std::string recorded = entry ? fmt::format(", ledger entry {}", *entry) : "";
  if (!refusal.empty()) return fmt::format("  refused{}: {} (--force)\n", recorded, refusal);
  return entry ? fmt::format("  installed{}\n", recorded) : "";
}

}  // namespace panelcal::calibrate
