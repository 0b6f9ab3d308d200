// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/calibrations/file_night.h"

#include <algorithm>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"

namespace panelcal::internal {

Expected<std::optional<std::string>> FileNight::text_in_force(const Ledger& ledger) const {
  std::optional<std::string> text;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (in_force) {
    PANELCAL_TRY(text, ledger.result(in_force->id));
  }
  return text;
}

bool FileNight::file_has(const std::string& text) const {
  const Expected<std::string> present = read_file(file(), kMaxLedgerResultBytes);
  return present && *present == text;
}

Expected<bool> FileNight::is_installed(const Ledger& ledger) const {
  PANELCAL_TRY(const std::optional<std::string> text, text_in_force(ledger));
  return !text || file_has(*text);
}

/// Only what was never installed, and is not of the time before the first installation, was put
/// there by hand. A damaged file is what the ledger is there for.
Expected<std::string> FileNight::by_hand(const Ledger& ledger) const {
  const std::string nothing;
  const Expected<std::string> bytes = read_file(file(), kMaxLedgerResultBytes);
  const auto date = bytes ? date_of(*bytes) : std::nullopt;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (!date || !in_force) return nothing;
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, installed_entries(ledger, key()));
  const std::string digest = sha256(*bytes);
  if (std::ranges::find(entries, digest, &LedgerEntry::result_sha256) != entries.end()) {
    return nothing;
  }
  return is_since_the_ledger(entries, *in_force, *date) ? std::string(thing()) : nothing;
}

Expected<bool> FileNight::install(const Ledger& ledger) {
  PANELCAL_TRY(const std::optional<std::string> text, text_in_force(ledger));
  if (!text || file_has(*text)) return false;
  PANELCAL_CHECK(write_file(file(), *text));
  return true;
}

}  // namespace panelcal::internal
