// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/database/rows.h"

#include <algorithm>
#include <limits>
#include <string>

#include "calib/base/clock.h"
#include "calib/ledger/entry/entry_text.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Conditions with the values to bind to them.
class Conditions {
 public:
  void add(std::string_view condition, std::string_view value) {
    sql_ += fmt::format("{} {} ?", sql_.empty() ? " WHERE" : " AND", condition);
    values_.emplace_back(value);
  }
  const std::string& sql() const { return sql_; }
  void bind(SqliteStatement& statement) const {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      statement.bind(static_cast<int>(i) + 1, values_[i]);
    }
  }

 private:
  std::string sql_;
  std::vector<std::string> values_;
};

Expected<std::vector<std::int64_t>> integers(SqliteStatement& statement) {
  std::vector<std::int64_t> out;
  while (true) {
    PANELCAL_TRY(const bool has_row, statement.step());
    if (!has_row) return out;
    out.push_back(statement.integer(0));
  }
}

}  // namespace

Expected<LedgerEntry> entry_of(SqliteConnection& connection, std::int64_t id) {
  const Place place{connection.file(), 0, 0};
  PANELCAL_TRY(SqliteStatement row,
               connection.prepare("SELECT previous, hash, content FROM ledger_entry WHERE id = ?"));
  row.bind(1, id);
  PANELCAL_TRY(const bool has_row, row.step());
  if (!has_row) {
    return failure({Code::LedgerEntryUnknown, place, fmt::format("entry {}", id), ""});
  }
  const std::string_view content = row.text(2);
  if (chained_hash(row.text(0), content) != row.text(1)) {
    return failure({Code::LedgerCorrupt, place, fmt::format("entry {} was changed", id), ""});
  }
  PANELCAL_TRY(LedgerEntry entry, parse_entry(content, connection.file()));
  entry.hash = row.text(1);
  if (entry.id == id) return entry;
  return failure({Code::LedgerCorrupt,
                  place,
                  fmt::format("entry {} has the content of entry {}", id, entry.id),
                  ""});
}

Expected<std::vector<std::int64_t>> ids_of(SqliteConnection& connection,
                                           const LedgerFilter& filter) {
  Conditions conditions;
  if (filter.machine) conditions.add("machine =", *filter.machine);
  if (filter.kind) conditions.add("kind =", word(*filter.kind));
  if (filter.subject) conditions.add("subject =", *filter.subject);
  // Texts of this form sort as their times do.
  if (filter.since) conditions.add("time >=", iso_8601(*filter.since));
  constexpr std::size_t kAll = std::numeric_limits<std::int64_t>::max();
  const std::size_t limit = std::min(filter.last.value_or(kAll), kAll);
  PANELCAL_TRY(SqliteStatement rows,
               connection.prepare(fmt::format("SELECT id FROM ledger_entry{} ORDER BY id DESC "
                                              "LIMIT {}",
                                              conditions.sql(),
                                              limit)));
  conditions.bind(rows);
  PANELCAL_TRY(std::vector<std::int64_t> ids, integers(rows));
  std::reverse(ids.begin(), ids.end());
  return ids;
}

Expected<std::optional<std::int64_t>> id_in_force(SqliteConnection& connection,
                                                  const LedgerKey& key) {
  PANELCAL_TRY(SqliteStatement rows,
               connection.prepare("SELECT coalesce(restores, id) FROM ledger_entry WHERE "
                                  "machine = ? AND kind = ? AND subject = ? AND "
                                  "verdict IN ('installed', 'rolled-back') "
                                  "ORDER BY id DESC LIMIT 1"));
  rows.bind(1, key.machine);
  rows.bind(2, word(key.kind));
  rows.bind(3, key.subject);
  PANELCAL_TRY(const std::vector<std::int64_t> ids, integers(rows));
  if (ids.empty()) return std::nullopt;
  return ids.front();
}

Expected<std::vector<std::int64_t>> ids_in_force(SqliteConnection& connection,
                                                 std::string_view machine) {
  // SQLite takes bare columns from the row that has the maximum.
  PANELCAL_TRY(SqliteStatement rows,
               connection.prepare("SELECT coalesce(restores, id), max(id) FROM ledger_entry WHERE "
                                  "machine = ? AND verdict IN ('installed', 'rolled-back') "
                                  "GROUP BY kind, subject ORDER BY kind, subject"));
  rows.bind(1, machine);
  return integers(rows);
}

}  // namespace panelcal::internal
