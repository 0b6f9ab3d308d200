// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/calibration.h"

#include <algorithm>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include <fmt/format.h>

namespace panelcal {

Expected<std::chrono::sys_seconds> Calibration::date_of(const std::string& /*bytes*/,
                                                        const std::string& /*name*/) const {
  return std::chrono::sys_seconds::max();
}

Expected<std::optional<std::string>> Calibration::text_in_force(const Ledger& ledger) const {
  std::optional<std::string> text;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (in_force) {
    PANELCAL_TRY(text, ledger.result(in_force->id));
    // Damage that the file shares is damage.
    PANELCAL_CHECK(date_of(*text, fmt::format("ledger entry {}", in_force->id)));
  }
  return text;
}

Expected<std::optional<std::string>> Calibration::missing_text(const Ledger& ledger) const {
  std::optional<std::string> text;
  if (file().empty()) return text;
  PANELCAL_TRY(text, text_in_force(ledger));
  const Expected<std::string> present = read_file(file(), kMaxLedgerResultBytes);
  if (text && present && *present == *text) text.reset();
  return text;
}

Expected<bool> Calibration::is_installed(const Ledger& ledger) const {
  PANELCAL_TRY(const std::optional<std::string> text, missing_text(ledger));
  return !text;
}

/// Only what was never installed, and is not of the time before the first installation, was put
/// there by hand. A damaged file is what the ledger is there for.
Expected<std::string> Calibration::by_hand(const Ledger& ledger) const {
  const std::string nothing;
  if (file().empty()) return nothing;
  const Expected<std::string> bytes = read_file(file(), kMaxLedgerResultBytes);
  if (!bytes) return nothing;
  const auto date = date_of(*bytes, "");
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (!date || !in_force) return nothing;
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, installed_entries(ledger, key()));
  const std::string digest = sha256(*bytes);
  if (std::ranges::find(entries, digest, &LedgerEntry::result_sha256) != entries.end()) {
    return nothing;
  }
  return is_since_the_ledger(entries, *in_force, *date) ? std::string(thing()) : nothing;
}

Expected<bool> Calibration::write_in_force(const Ledger& ledger) const {
  PANELCAL_TRY(const std::optional<std::string> text, missing_text(ledger));
  if (!text) return false;
  PANELCAL_CHECK(write_file(file(), *text));
  return true;
}

Expected<bool> Calibration::install(const Ledger& ledger) {
  PANELCAL_TRY(const bool is_written, write_in_force(ledger));
  PANELCAL_CHECK(begin_there(ledger));
  return is_written;
}

}  // namespace panelcal
