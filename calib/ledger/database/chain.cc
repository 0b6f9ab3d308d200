// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/database/chain.h"

#include <algorithm>
#include <string>
#include <utility>

#include "calib/base/files/digest.h"
#include "calib/ledger/entry/entry_text.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Columns of every statement here.
constexpr int kId = 0;
constexpr int kPrevious = 1;
constexpr int kHash = 2;
constexpr int kContent = 3;
constexpr int kResult = 4;

Diagnostic broken(const SqliteConnection& connection, std::int64_t id, std::string_view how) {
  return {Code::LedgerCorrupt,
          {connection.file(), 0, 0},
          fmt::format("entry {} {}", id, how),
          "it as it was recorded"};
}

/// One row after its predecessor.
Expected<void> check_row(const SqliteConnection& connection,
                         const SqliteStatement& row,
                         const LedgerHead& before) {
  const std::int64_t id = row.integer(kId);
  if (id != before.id + 1) return failure(broken(connection, before.id + 1, "is missing"));
  if (row.text(kPrevious) != before.hash) {
    return failure(broken(connection, id, "does not follow the entry before it"));
  }
  if (row.text(kHash) != chained_hash(row.text(kPrevious), row.text(kContent))) {
    return failure(broken(connection, id, "was changed"));
  }
  return {};
}

Expected<void> check_content(const SqliteConnection& connection, const SqliteStatement& row) {
  PANELCAL_TRY(const LedgerEntry entry, parse_entry(row.text(kContent), connection.file()));
  const std::int64_t id = row.integer(kId);
  if (entry.id != id) return failure(broken(connection, id, "has the content of another one"));
  const std::string_view result = row.text(kResult);
  if (result.size() != entry.result_bytes || sha256(result) != entry.result_sha256) {
    return failure(broken(connection, id, "has another result than was recorded"));
  }
  return {};
}

/// Checks all entries after `head`, and moves it to the last of them.
Expected<void> check_after(SqliteConnection& connection, LedgerHead& head) {
  PANELCAL_TRY(SqliteStatement rows,
               connection.prepare("SELECT id, previous, hash, content, result FROM ledger_entry "
                                  "WHERE id > ? ORDER BY id"));
  rows.bind(1, head.id);
  while (true) {
    PANELCAL_TRY(const bool has_row, rows.step());
    if (!has_row) return {};
    PANELCAL_CHECK(check_row(connection, rows, head));
    PANELCAL_CHECK(check_content(connection, rows));
    head = {rows.integer(kId), std::string(rows.text(kHash))};
  }
}

Expected<std::string> hash_of(SqliteConnection& connection, std::int64_t id) {
  if (id == 0) return std::string(kNoHash);
  PANELCAL_TRY(SqliteStatement row,
               connection.prepare("SELECT id, previous, hash FROM ledger_entry WHERE id = ?"));
  row.bind(1, id);
  PANELCAL_TRY(const bool has_row, row.step());
  if (!has_row) return failure(broken(connection, id, "is missing"));
  return std::string(row.text(kHash));
}

}  // namespace

Expected<LedgerHead> checked_head(SqliteConnection& connection) {
  PANELCAL_TRY(
      SqliteStatement row,
      connection.prepare("SELECT id, previous, hash, content FROM ledger_entry ORDER BY id DESC "
                         "LIMIT 1"));
  PANELCAL_TRY(const bool has_row, row.step());
  if (!has_row) return LedgerHead{0, std::string(kNoHash)};
  const std::int64_t id = row.integer(kId);
  if (row.text(kHash) != chained_hash(row.text(kPrevious), row.text(kContent))) {
    return failure(broken(connection, id, "was changed"));
  }
  return LedgerHead{id, std::string(row.text(kHash))};
}

Expected<void> check_newest(SqliteConnection& connection, std::size_t n) {
  // One state of the ledger for all statements, whatever others record meanwhile.
  PANELCAL_TRY(SqliteTransaction reading, SqliteTransaction::begin(connection, "BEGIN"));
  PANELCAL_TRY(const std::int64_t last,
               connection.integer_of("SELECT coalesce(max(id), 0) FROM ledger_entry"));
  PANELCAL_TRY(const std::int64_t n_entries,
               connection.integer_of("SELECT count(*) FROM ledger_entry"));
  if (n_entries != last) {
    return failure({Code::LedgerCorrupt,
                    {connection.file(), 0, 0},
                    fmt::format("{} of {} entries are there", n_entries, last),
                    "all of them"});
  }
  LedgerHead head;
  head.id = std::max<std::int64_t>(0, last - static_cast<std::int64_t>(n));
  PANELCAL_TRY(head.hash, hash_of(connection, head.id));
  PANELCAL_CHECK(check_after(connection, head));
  return reading.commit();
}

Expected<LedgerHead> check_all(SqliteConnection& connection) {
  PANELCAL_TRY(SqliteTransaction reading, SqliteTransaction::begin(connection, "BEGIN"));
  PANELCAL_TRY(const std::string verdict, connection.text_of("PRAGMA integrity_check(1)"));
  if (verdict != "ok") {
    return failure({Code::LedgerCorrupt,
                    {connection.file(), 0, 0},
                    "the file is damaged: " + quoted(verdict, 200),
                    ""});
  }
  LedgerHead head{0, std::string(kNoHash)};
  PANELCAL_CHECK(check_after(connection, head));
  PANELCAL_CHECK(reading.commit());
  if (head.id == 0) head.hash.clear();
  return head;
}

}  // namespace panelcal::internal
