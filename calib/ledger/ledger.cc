// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/ledger.h"

#include <algorithm>
#include <utility>

#include "calib/base/files/digest.h"
#include "calib/ledger/database/chain.h"
#include "calib/ledger/database/file.h"
#include "calib/ledger/database/rows.h"
#include "calib/ledger/database/sqlite.h"
#include "calib/ledger/entry/entry_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::SqliteConnection;
using internal::SqliteStatement;
using internal::SqliteTransaction;

/// Text in the place of a missing calibration; JSON like the others.
constexpr std::string_view kNoResult = "null";

Diagnostic invalid_ledger(const SqliteConnection& connection,
                          std::string what,
                          std::string expected) {
  return {
      Code::LedgerEntryInvalid, {connection.file(), 0, 0}, std::move(what), std::move(expected)};
}

/// A name for the entry that is in force, for messages.
std::string named(const std::optional<std::int64_t>& id) {
  return id ? fmt::format("entry {}", *id) : "nothing";
}

/// Writes one entry behind `head`, and moves `head` to it.
Expected<LedgerEntry> insert(SqliteConnection& connection,
                             LedgerEntry entry,
                             std::string_view result,
                             LedgerHead& head) {
  entry.id = head.id + 1;
  entry.result_sha256 = sha256(result);
  entry.result_bytes = result.size();
  const std::string content = ledger_entry_json(entry);
  entry.hash = internal::chained_hash(head.hash, content);
  PANELCAL_TRY(SqliteStatement statement,
               connection.prepare("INSERT INTO ledger_entry(id, previous, hash, content, result) "
                                  "VALUES (?, ?, ?, ?, ?)"));
  statement.bind(1, entry.id);
  statement.bind(2, head.hash);
  statement.bind(3, entry.hash);
  statement.bind(4, content);
  statement.bind(5, result);
  PANELCAL_CHECK(statement.step());
  head = {entry.id, entry.hash};
  return entry;
}

/// Fills in what the entry takes out of force, or refuses it if that is not as the caller thought.
Expected<void> settle_replaced(SqliteConnection& connection, LedgerRecord& record) {
  if (record.verdict != LedgerVerdict::Installed) return {};
  PANELCAL_TRY(const std::optional<std::int64_t> present,
               internal::id_in_force(connection, record.key));
  if (record.replaces && record.replaces != present) {
    return failure(
        invalid_ledger(connection,
                       named(present) + " is in force by now",
                       fmt::format("entry {}, which this one should replace", *record.replaces)));
  }
  record.replaces = present;
  return {};
}

/// Checks that an entry recorded now would be found again under the ledger's name.
Expected<void> check_in_place(SqliteConnection& connection) {
  if (!connection.has_moved()) return internal::check_version(connection);
  return failure({Code::DeviceWrite,
                  {connection.file(), 0, 0},
                  "nothing was recorded: the file was moved or deleted since it was opened",
                  "it in its place"});
}

/// Runs `work` with the time and the newest entry, alone on the ledger; all that it inserts is
/// recorded or nothing.
Expected<void> record(
    SqliteConnection& connection,
    const Clock& clock,
    const std::function<Expected<void>(std::chrono::sys_seconds, LedgerHead&)>& work) {
  if (!clock) {
    return failure(
        {Code::DeviceWrite, {connection.file(), 0, 0}, "it was opened only to be read", ""});
  }
  PANELCAL_TRY(SqliteTransaction writing, SqliteTransaction::begin(connection));
  PANELCAL_CHECK(check_in_place(connection));
  PANELCAL_TRY(LedgerHead head, internal::checked_head(connection));
  // Asked for once the ledger is ours, so that waiting for others does not mix up the times.
  const std::chrono::sys_seconds now = clock();
  if (from_iso_8601(iso_8601(now)) != now) {
    return failure(
        invalid_ledger(connection, "the clock says " + iso_8601(now), "years 0 to 9999"));
  }
  PANELCAL_CHECK(work(now, head));
  return writing.commit();
}

/// The installed entry that the request wants in force again.
Expected<std::int64_t> entry_to_restore(SqliteConnection& connection,
                                        const Ledger::RollBack& request,
                                        std::int64_t present) {
  if (!request.to) {
    PANELCAL_TRY(const LedgerEntry entry, internal::entry_of(connection, present));
    if (entry.record.replaces) return *entry.record.replaces;
    return failure(invalid_ledger(connection,
                                  fmt::format("entry {} was the first of its kind", present),
                                  "an earlier one to go back to"));
  }
  PANELCAL_TRY(const LedgerEntry entry, internal::entry_of(connection, *request.to));
  if (entry.record.verdict != LedgerVerdict::Installed || !(entry.record.key == request.key)) {
    return failure(invalid_ledger(
        connection,
        fmt::format("entry {} is {}, {} {} of {}",
                    entry.id,
                    word(entry.record.verdict),
                    word(entry.record.key.kind),
                    quoted(entry.record.key.subject),
                    quoted(entry.record.key.machine)),
        fmt::format(
            "an installed one of {} {}", word(request.key.kind), quoted(request.key.subject))));
  }
  if (entry.id != present) return entry.id;
  return failure(invalid_ledger(
      connection, fmt::format("entry {} is in force already", entry.id), "another one"));
}

}  // namespace

Ledger::Ledger(std::unique_ptr<SqliteConnection> connection, Clock clock)
    : connection_(std::move(connection)), clock_(std::move(clock)) {
}

Ledger::Ledger(Ledger&&) noexcept = default;
Ledger& Ledger::operator=(Ledger&&) noexcept = default;
Ledger::~Ledger() = default;

Expected<Ledger> Ledger::open(const std::filesystem::path& path,
                              Clock clock,
                              const LedgerOptions& options) {
  std::error_code ignored;
  if (std::filesystem::status(path, ignored).type() == std::filesystem::file_type::not_found) {
    PANELCAL_CHECK(internal::create_ledger_file(path));
  }
  PANELCAL_TRY(std::unique_ptr<SqliteConnection> connection,
               internal::open_ledger_file(path, SqliteConnection::Mode::Write, options));
  return Ledger(std::move(connection), std::move(clock));
}

Expected<Ledger> Ledger::open_to_read(const std::filesystem::path& path,
                                      const LedgerOptions& options) {
  const auto open = [&](SqliteConnection::Mode mode) {
    return internal::open_ledger_file(path, mode, options);
  };
  auto connection = open(SqliteConnection::Mode::Read);
  if (!connection && connection.error().code == Code::FileUnreadable) {
    // A write that was killed has to be undone first, which needs a connection that may write.
    if (const auto undone = open(SqliteConnection::Mode::Write)) {
      connection = open(SqliteConnection::Mode::Read);
    }
  }
  if (!connection) return failure(std::move(connection).error());
  return Ledger(*std::move(connection), Clock());
}

Expected<std::vector<LedgerEntry>> Ledger::append_all(std::span<const LedgerDraft> drafts) {
  for (const LedgerDraft& draft : drafts) {
    PANELCAL_CHECK(internal::check_draft(draft, connection_->file()));
  }
  std::vector<LedgerEntry> entries;
  const auto insert_all = [&](std::chrono::sys_seconds now, LedgerHead& head) -> Expected<void> {
    for (const LedgerDraft& draft : drafts) {
      LedgerEntry entry{.time = now, .record = draft.record};
      PANELCAL_CHECK(settle_replaced(*connection_, entry.record));
      PANELCAL_TRY(LedgerEntry inserted,
                   insert(*connection_, std::move(entry), draft.result, head));
      entries.push_back(std::move(inserted));
    }
    return {};
  };
  PANELCAL_CHECK(record(*connection_, clock_, insert_all));
  return entries;
}

Expected<LedgerEntry> Ledger::append(const LedgerDraft& draft) {
  PANELCAL_TRY(std::vector<LedgerEntry> entries, append_all({&draft, 1}));
  return std::move(entries.front());
}

Expected<LedgerEntry> Ledger::roll_back(const RollBack& request) {
  LedgerEntry entry;
  entry.record.key = request.key;
  entry.record.verdict = LedgerVerdict::RolledBack;
  entry.record.reason = request.reason;
  entry.record.asked_by = request.asked_by;
  entry.record.software = request.software;
  PANELCAL_CHECK(internal::check_record(entry.record, connection_->file()));
  const auto insert_it = [&](std::chrono::sys_seconds now, LedgerHead& head) -> Expected<void> {
    PANELCAL_TRY(entry.record.replaces, internal::id_in_force(*connection_, request.key));
    if (!entry.record.replaces) {
      return failure(invalid_ledger(*connection_,
                                    fmt::format("nothing is in force for {} {} of {}",
                                                word(request.key.kind),
                                                quoted(request.key.subject),
                                                quoted(request.key.machine)),
                                    "an installed calibration"));
    }
    PANELCAL_TRY(entry.restores, entry_to_restore(*connection_, request, *entry.record.replaces));
    entry.time = now;
    PANELCAL_TRY(entry, insert(*connection_, entry, kNoResult, head));
    return {};
  };
  PANELCAL_CHECK(record(*connection_, clock_, insert_it));
  return entry;
}

}  // namespace panelcal
