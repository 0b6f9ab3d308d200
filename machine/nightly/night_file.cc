// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/nightly/night_file.h"

#include <algorithm>
#include <vector>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/digest.h"
#include "panelcal/calib/table_calibration_file.h"

namespace panelcal::internal {

Expected<std::optional<std::string>> text_in_force(const Ledger& ledger, const LedgerKey& key) {
  std::optional<std::string> text;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key));
  if (in_force) {
    PANELCAL_TRY(text, ledger.result(in_force->id));
  }
  return text;
}

Expected<bool> says_what_is_in_force(const Ledger& ledger,
                                     const LedgerKey& key,
                                     const std::filesystem::path& file) {
  PANELCAL_TRY(const std::optional<std::string> text, text_in_force(ledger, key));
  if (!text) return true;
  // The largest of all calibrations.
  const Expected<std::string> present = read_file(file, kMaxTableCalibrationBytes);
  return present && *present == *text;
}

Expected<bool> is_past_the_ledger(const Ledger& ledger,
                                  const LedgerKey& key,
                                  const std::string& bytes,
                                  std::chrono::sys_seconds date) {
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key));
  if (!in_force) return false;
  LedgerFilter filter;
  filter.machine = key.machine;
  filter.kind = key.kind;
  filter.subject = key.subject;
  PANELCAL_TRY(std::vector<LedgerEntry> entries, ledger.list(filter));
  std::erase_if(entries, [](const LedgerEntry& entry) {
    return entry.record.verdict != LedgerVerdict::Installed;
  });
  const std::string digest = sha256(bytes);
  if (std::ranges::find(entries, digest, &LedgerEntry::result_sha256) != entries.end()) {
    return false;
  }
  // The first installation may have been cut off before it replaced what was there without a
  // ledger.
  return entries.size() != 1 || date > in_force->time;
}

}  // namespace panelcal::internal
