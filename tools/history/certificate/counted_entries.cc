// SPDX-License-Identifier: Apache-2.0
#include "tools/history/certificate/counted_entries.h"

#include <algorithm>

#include <fmt/format.h>

namespace panelcal::history {
namespace {

/// Adds a night's scatter to that of the nights before.
void pool(Repeatability& all, const NightSpread& night) {
  Scatter& scatter = all.scatter;
  const double degrees = scatter.degrees_of_freedom + night.degrees_of_freedom;
  scatter.variance =
      (scatter.variance * scatter.degrees_of_freedom + night.variance * night.degrees_of_freedom) /
      degrees;
  scatter.degrees_of_freedom = degrees;
  ++all.n_nights;
}

}  // namespace

std::map<std::string, std::vector<const LedgerEntry*>> CountedEntries::of_kind(
    LedgerKind kind) const {
  std::map<std::string, std::vector<const LedgerEntry*>> out;
  for (const LedgerEntry& entry : entries_) {
    const LedgerRecord& record = entry.record;
    if (record.key.kind == kind && record.verdict != LedgerVerdict::RolledBack) {
      out[record.key.subject].push_back(&entry);
    }
  }
  return out;
}

std::optional<std::int64_t> CountedEntries::fresh_start_of(const LedgerKey& key) const {
  const auto found = newest_.find(fresh_start_key(key).subject);
  if (found == newest_.end()) return std::nullopt;
  return found->second;
}

void CountedEntries::note(const LedgerEntry& entry) {
  const LedgerRecord& record = entry.record;
  if (record.key.kind == LedgerKind::Night) newest_[record.key.subject] = entry.id;
  if (record.verdict != LedgerVerdict::RolledBack || !entry.restores) return;
  for (const LedgerEntry& one : entries_) {
    const bool is_between = one.id > *entry.restores && one.id < entry.id;
    if (is_between && one.record.key == record.key) rolled_back_.insert(one.id);
  }
}

std::vector<Repeatability> repeatability_of(const CountedEntries& entries) {
  std::vector<Repeatability> out;
  entries.for_each_companion([&](const LedgerEntry& calibration, const QualityNight& night) {
    const LedgerKey& key = calibration.record.key;
    const std::string subject = fmt::format("{} {}", word(key.kind), key.subject);
    for (const NightSpread& spread : night.spreads) {
      if (!(spread.degrees_of_freedom > 0)) continue;
      auto found = std::ranges::find_if(out, [&](const Repeatability& one) {
        return one.subject == subject && one.name == spread.name && one.unit == spread.unit;
      });
      if (found == out.end()) {
        found = out.insert(found, {subject, spread.name, spread.unit, 0, {}});
      }
      pool(*found, spread);
    }
  });
  return out;
}

}  // namespace panelcal::history
