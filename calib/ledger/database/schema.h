// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

// Not installed.
namespace panelcal::internal {

/// "PCAL", in the file's header, where `file` and SQLite's tools look for it.
inline constexpr std::int64_t kLedgerApplicationId = 0x5043414C;
inline constexpr std::int64_t kLedgerVersion = 1;

/// Stands in the schema, and so near the start of every ledger's file.
inline constexpr std::string_view kSchemaMark = "panelcal ledger: entries are only added";

/// `content` is the entry; the columns to look it up by are computed from it, so that they cannot
/// say anything else. The triggers keep out mistakes made with other tools; the hashes tell.
/// INSERT OR REPLACE would delete without a delete trigger, but only where an id is taken.
inline constexpr std::string_view kLedgerSchema = R"sql(
CREATE TABLE ledger_entry(
  id INTEGER PRIMARY KEY,
  previous TEXT NOT NULL,
  hash TEXT NOT NULL,
  content TEXT NOT NULL,
  result TEXT NOT NULL,
  time TEXT AS (json_extract(content, '$.time')),
  machine TEXT AS (json_extract(content, '$.machine')),
  kind TEXT AS (json_extract(content, '$.kind')),
  subject TEXT AS (json_extract(content, '$.subject')),
  verdict TEXT AS (json_extract(content, '$.verdict')),
  restores INTEGER AS (json_extract(content, '$.restores'))
) STRICT;
CREATE INDEX ledger_entry_by_key ON ledger_entry(machine, kind, subject, verdict);
CREATE TRIGGER ledger_entry_update BEFORE UPDATE ON ledger_entry BEGIN
  SELECT RAISE(ABORT, 'panelcal ledger: entries are only added');
END;
CREATE TRIGGER ledger_entry_delete BEFORE DELETE ON ledger_entry BEGIN
  SELECT RAISE(ABORT, 'panelcal ledger: entries are only added');
END;
CREATE TRIGGER ledger_entry_insert BEFORE INSERT ON ledger_entry
  WHEN NEW.id IS NOT (SELECT coalesce(max(id), 0) + 1 FROM ledger_entry) BEGIN
  SELECT RAISE(ABORT, 'panelcal ledger: entries are only added');
END;
)sql";

}  // namespace panelcal::internal
