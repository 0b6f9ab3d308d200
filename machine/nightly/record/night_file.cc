// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_file.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/calibrate/calibration_record.h"

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
  const Expected<std::string> present = read_file(file, kMaxLedgerResultBytes);
  return present && *present == *text;
}

Expected<std::string> by_hand_in(const Ledger& ledger,
                                 const LedgerKey& key,
                                 const std::filesystem::path& file,
                                 std::string words,
                                 const DateOfBytes& date_of) {
  const std::string nothing;
  const Expected<std::string> bytes = read_file(file, kMaxLedgerResultBytes);
  const auto date = bytes ? date_of(*bytes) : std::nullopt;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key));
  if (!date || !in_force) return nothing;
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, installed_entries(ledger, key));
  const std::string digest = sha256(*bytes);
  if (std::ranges::find(entries, digest, &LedgerEntry::result_sha256) != entries.end()) {
    return nothing;
  }
  return is_since_the_ledger(entries, *in_force, *date) ? words : nothing;
}

Expected<bool> write_what_is_in_force(const Ledger& ledger,
                                      const LedgerKey& key,
                                      const std::filesystem::path& file) {
  PANELCAL_TRY(const bool is_there, says_what_is_in_force(ledger, key, file));
  if (is_there) return false;
  PANELCAL_TRY(const std::optional<std::string> text, text_in_force(ledger, key));
  if (!text) return false;
  PANELCAL_CHECK(write_file(file, *text));
  return true;
}

}  // namespace panelcal::internal
