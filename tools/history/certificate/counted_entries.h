// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calib/ledger/ledger.h"
#include "machine/nightly/record/night_history.h"
#include "tools/history/certificate/certificate.h"

namespace panelcal::history {

/// The entries of one machine that count: installed, not rolled back since, and not before the
/// newest fresh start of what they calibrate.
class CountedEntries {
 public:
  explicit CountedEntries(const std::vector<LedgerEntry>& entries) : entries_(entries) {
    for (const LedgerEntry& entry : entries) note(entry);
  }

  /// All of a kind, by subject.
  std::map<std::string, std::vector<const LedgerEntry*>> of_kind(LedgerKind kind) const;

  std::optional<std::int64_t> fresh_start_of(const LedgerKey& key) const;
  bool is_since_fresh_start(const LedgerEntry& entry) const {
    return entry.id > fresh_start_of(entry.record.key).value_or(0);
  }
  bool is_rolled_back(const LedgerEntry& entry) const { return rolled_back_.contains(entry.id); }
  bool counts(const LedgerEntry& entry) const {
    return entry.record.verdict == LedgerVerdict::Installed && !is_rolled_back(entry) &&
           is_since_fresh_start(entry);
  }

  /// Each entry that a night has recorded beside a calibration which counts.
  template <class Visit>
  void for_each_companion(const Visit& visit) const {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
      const LedgerEntry& companion = entries_[i];
      const LedgerEntry& calibration = entries_[i - 1];
      if (companion.id != calibration.id + 1 ||
          companion.record.key != companion_key(calibration.record.key)) {
        continue;
      }
      if (counts(calibration)) visit(calibration, qualities_of(companion));
    }
  }

 private:
  void note(const LedgerEntry& entry);

  const std::vector<LedgerEntry>& entries_;
  std::map<std::string, std::int64_t> newest_;  ///< of the kind Night, by subject
  std::set<std::int64_t> rolled_back_;
};

/// The scatters that nights have observed, each over all nights that count.
std::vector<Repeatability> repeatability_of(const CountedEntries& entries);

}  // namespace panelcal::history
