// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/files/digest.h"
#include "calib/ledger/database/chain.h"
#include "calib/ledger/database/file.h"
#include "calib/ledger/database/rows.h"
#include "calib/ledger/database/sqlite.h"
#include "calib/ledger/ledger.h"
#include <fmt/format.h>

namespace panelcal {

using internal::SqliteStatement;

Expected<void> Ledger::for_each(
    const LedgerFilter& filter,
    const std::function<Expected<void>(const LedgerEntry&)>& visit) const {
  // The ids first, so that no program waits for the ledger while the visitor takes its time.
  // Entries never change, so they are the same when they are read.
  PANELCAL_TRY(const std::vector<std::int64_t> ids, internal::ids_of(*connection_, filter));
  for (const std::int64_t id : ids) {
    PANELCAL_TRY(const LedgerEntry one, internal::entry_of(*connection_, id));
    PANELCAL_CHECK(visit(one));
  }
  return {};
}

Expected<std::vector<LedgerEntry>> Ledger::list(const LedgerFilter& filter) const {
  std::vector<LedgerEntry> entries;
  PANELCAL_CHECK(for_each(filter, [&entries](const LedgerEntry& one) -> Expected<void> {
    entries.push_back(one);
    return {};
  }));
  return entries;
}

Expected<std::vector<LedgerEntry>> Ledger::list(const LedgerKey& key,
                                                std::optional<std::size_t> last) const {
  return list(LedgerFilter{key.machine, key.kind, key.subject, {}, last});
}

Expected<LedgerEntry> Ledger::entry(std::int64_t id) const {
  return internal::entry_of(*connection_, id);
}

Expected<std::string> Ledger::result(std::int64_t id) const {
  PANELCAL_TRY(const LedgerEntry one, internal::entry_of(*connection_, id));
  PANELCAL_TRY(SqliteStatement row,
               connection_->prepare("SELECT result FROM ledger_entry WHERE id = ?"));
  row.bind(1, id);
  PANELCAL_CHECK(row.step());
  const std::string_view text = row.text(0);
  if (sha256(text) == one.result_sha256) return std::string(text);
  return failure({Code::LedgerCorrupt,
                  {connection_->file(), 0, 0},
                  fmt::format("entry {} has another result than was recorded", id),
                  ""});
}

Expected<std::optional<LedgerEntry>> Ledger::in_force(const LedgerKey& key) const {
  PANELCAL_TRY(const std::optional<std::int64_t> id, internal::id_in_force(*connection_, key));
  if (!id) return std::nullopt;
  PANELCAL_TRY(LedgerEntry one, internal::entry_of(*connection_, *id));
  return one;
}

Expected<std::vector<LedgerEntry>> Ledger::all_in_force(std::string_view machine) const {
  PANELCAL_TRY(const std::vector<std::int64_t> ids, internal::ids_in_force(*connection_, machine));
  std::vector<LedgerEntry> entries;
  for (const std::int64_t id : ids) {
    PANELCAL_TRY(LedgerEntry one, internal::entry_of(*connection_, id));
    entries.push_back(std::move(one));
  }
  return entries;
}

Expected<LedgerSeries> Ledger::series(const LedgerKey& key, std::string_view parameter) const {
  LedgerSeries series;
  const auto take = [&](const LedgerEntry& one) -> Expected<void> {
    const std::vector<LedgerParameter>& all = one.record.parameters;
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const LedgerParameter& p) { return p.name == parameter; });
    if (found == all.end()) return {};
    if (!series.points.empty() && found->unit != series.unit) {
      return failure({Code::LedgerEntryInvalid,
                      {connection_->file(), 0, 0},
                      fmt::format("{} is in {} from entry {} on, and in {} before",
                                  quoted(parameter),
                                  quoted(found->unit),
                                  one.id,
                                  quoted(std::as_const(series.unit))),
                      "one unit"});
    }
    series.unit = found->unit;
    const std::optional<Eigen::MatrixXd>& cov = one.record.covariance;
    const auto i = found - all.begin();
    const std::optional<double> sigma =
        cov ? std::optional<double>(std::sqrt((*cov)(i, i))) : std::nullopt;
    series.points.push_back(
        {one.id, one.time, found->value, sigma, one.record.temperature_degC, one.record.verdict});
    return {};
  };
  PANELCAL_CHECK(
      for_each({.machine = key.machine, .kind = key.kind, .subject = key.subject}, take));
  return series;
}

Expected<LedgerHead> Ledger::head() const {
  PANELCAL_TRY(LedgerHead newest, internal::checked_head(*connection_));
  if (newest.id == 0) newest.hash.clear();
  return newest;
}

Expected<LedgerHead> Ledger::verify() const {
  PANELCAL_CHECK(internal::check_version(*connection_));
  return internal::check_all(*connection_);
}

}  // namespace panelcal
