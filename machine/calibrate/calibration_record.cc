// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/calibration_record.h"

#include <system_error>
#include <utility>

#include "calib/base/fields/noted_head.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/camera/calibration/calibration_file.h"

namespace panelcal {

LedgerRecord record_of(LedgerKey key, const RecordWords& words) {
  LedgerRecord record;
  record.key = std::move(key);
  record.verdict = words.verdict;
  record.reason = words.reason;
  record.asked_by = words.asked_by;
  record.software = words.software;
  record.temperature_degC = words.temperature_degC;
  return record;
}

Expected<void> add_inputs(std::initializer_list<std::filesystem::path> files,
                          std::vector<LedgerInput>& inputs) {
  for (const std::filesystem::path& file : files) {
    if (file.empty()) continue;
    PANELCAL_TRY(LedgerInput input, input_of(file));
    inputs.push_back(std::move(input));
  }
  return {};
}

Expected<LedgerDraft> draft_of(const MachineConfig& config,
                               LedgerKey key,
                               const RecordWords& words) {
  LedgerDraft draft;
  draft.record = record_of(std::move(key), words);
  PANELCAL_CHECK(add_inputs({config.file}, draft.record.inputs));
  return draft;
}

Expected<LedgerInput> input_of(const std::filesystem::path& file, std::size_t max_bytes) {
  PANELCAL_TRY(const std::string bytes, read_file(file, max_bytes));
  return LedgerInput{file.filename().string(), sha256(bytes), bytes.size()};
}

Expected<void> note_head(const Ledger& ledger, LedgerDraft& draft) {
  PANELCAL_TRY(const LedgerHead head, ledger.head());
  draft.result = internal::with_noted_head(
      std::move(draft.result), {internal::NotedHead::Use::RecordedAfter, head.id, head.hash});
  return {};
}

Expected<std::string> text_with_head(const MachineConfig& config, std::string text) {
  std::error_code ignored;
  if (config.ledger_file.empty() || !std::filesystem::exists(config.ledger_file, ignored)) {
    return text;
  }
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(config.ledger_file));
  PANELCAL_TRY(const LedgerHead head, ledger.head());
  return internal::with_noted_head(std::move(text),
                                   {internal::NotedHead::Use::Head, head.id, head.hash});
}

Expected<std::vector<LedgerEntry>> installed_entries(const Ledger& ledger, const LedgerKey& key) {
  PANELCAL_TRY(std::vector<LedgerEntry> entries, ledger.list(key, std::nullopt));
  std::erase_if(entries, [](const LedgerEntry& entry) {
    return entry.record.verdict != LedgerVerdict::Installed;
  });
  return entries;
}

bool is_since_the_ledger(const std::vector<LedgerEntry>& installed,
                         const LedgerEntry& in_force,
                         std::chrono::sys_seconds date) {
  return installed.size() != 1 || date > in_force.time;
}

std::string by_whom(const RecordWords& words) {
  std::string out;
  if (!words.asked_by.empty()) out += ", for " + words.asked_by;
  if (!words.software.empty()) out += ", by " + words.software;
  return out;
}

}  // namespace panelcal
