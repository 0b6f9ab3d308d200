// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/database/file.h"

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "calib/base/files/file_rights.h"
#include "calib/ledger/database/chain.h"
#include "calib/ledger/database/schema.h"
#include "calib/ledger/database/wreck.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal::internal {
namespace {

namespace fs = std::filesystem;

Diagnostic problem(Code code, const fs::path& path, std::string what, std::string expected = "") {
  return {code, {path.string(), 0, 0}, std::move(what), std::move(expected)};
}

Diagnostic not_written(const fs::path& path, std::string_view doing, int error) {
  return problem(Code::DeviceWrite,
                 path,
                 fmt::format("cannot {}: {}", doing, std::generic_category().message(error)));
}

void sync_ledger_folder(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

/// Renames where nothing stands; EEXIST otherwise. Returns 0 or the error.
int rename_to_free_name(const fs::path& from, const fs::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // A file system that cannot do both at once.
  struct stat status {};
  if (::lstat(to.c_str(), &status) == 0) return EEXIST;
  return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

Expected<void> write_schema(const fs::path& path, const fs::path& named) {
  const auto to_named = [&named](Diagnostic diagnostic) {
    diagnostic.place.file = named.string();
    return failure(std::move(diagnostic));
  };
  auto connection =
      SqliteConnection::open(path, SqliteConnection::Mode::Write, std::chrono::milliseconds(0));
  if (!connection) return to_named(std::move(connection).error());
  const std::string sql = fmt::format(
      "PRAGMA journal_mode=DELETE; PRAGMA synchronous=EXTRA; BEGIN; PRAGMA application_id={}; "
      "PRAGMA user_version={}; {} COMMIT;",
      kLedgerApplicationId,
      kLedgerVersion,
      kLedgerSchema);
  Expected<void> done = (*connection)->run(sql);
  if (!done) return to_named(std::move(done).error());
  return {};
}

/// The schema as SQLite keeps it, in an order of its own.
Expected<std::string> schema_of(SqliteConnection& connection) {
  return connection.text_of(
      "SELECT group_concat(sql, ';' || char(10)) FROM (SELECT sql FROM sqlite_schema "
      "WHERE sql IS NOT NULL ORDER BY rowid)");
}

/// The text between the statements that CREATE does not keep is a semicolon and a line break.
std::string expected_schema() {
  std::string text(kLedgerSchema.substr(1));
  text.resize(text.size() - 2);
  return text;
}

/// The schema first: what a file from elsewhere brings along must not be run.
Expected<void> check_structure(SqliteConnection& connection) {
  const Place place{connection.file(), 0, 0};
  PANELCAL_TRY(const std::string schema, schema_of(connection));
  if (schema != expected_schema()) {
    return failure({Code::LedgerCorrupt, place, "its tables or triggers were changed", ""});
  }
  PANELCAL_TRY(const std::string verdict, connection.text_of("PRAGMA quick_check(1)"));
  if (verdict == "ok") return {};
  return failure({Code::LedgerCorrupt, place, "the file is damaged: " + quoted(verdict, 200), ""});
}

Expected<void> check_exists(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found || error) {
    const std::string why = error ? error.message() : "there is no such file";
    return failure(problem(Code::FileUnreadable, path, why, "a ledger"));
  }
  if (status.type() != fs::file_type::regular) {
    return failure(problem(Code::LedgerForeign, path, "it is a folder or a device", "a ledger"));
  }
  const std::uintmax_t size = fs::file_size(path, error);
  if (!error && size == 0) {
    return failure(problem(Code::LedgerCorrupt, path, "the file is empty", ""));
  }
  return {};
}

Expected<void> prepare_connection(SqliteConnection& connection, SqliteConnection::Mode mode) {
  // EXTRA also syncs the folder once the journal is gone: without it a power cut could bring the
  // journal back, and with it undo what was acknowledged.
  PANELCAL_CHECK(connection.run(
      "PRAGMA temp_store=MEMORY; PRAGMA cell_size_check=ON; PRAGMA synchronous=EXTRA;"));
  if (mode == SqliteConnection::Mode::Read) return connection.run("PRAGMA query_only=ON");
  return {};
}

Expected<void> check_journal_mode(SqliteConnection& connection) {
  PANELCAL_TRY(const std::string mode, connection.text_of("PRAGMA journal_mode=DELETE"));
  if (mode == "delete") return {};
  return failure({Code::LedgerBusy,
                  {connection.file(), 0, 0},
                  "it is in journal mode " + quoted(mode) + ", set by another program",
                  "that program to close it"});
}

}  // namespace

Expected<void> create_ledger_file(const fs::path& path) {
  // In the same folder, so that it can be renamed; a power cut leaves at most this file behind.
  std::string temporary = path.string() + ".new-XXXXXX";
  const int fd = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (fd < 0) return failure(not_written(path, "start a ledger there", errno));
  ::fchmod(fd, usual_file_rights());
  ::close(fd);
  const Expected<void> written = write_schema(temporary, path);
  const int error = written ? rename_to_free_name(temporary, path) : 0;
  if (!written || error != 0) ::unlink(temporary.c_str());
  if (!written) {
    ::unlink((temporary + "-journal").c_str());
    return failure(written.error());
  }
  // Another program was faster: its ledger is as good.
  if (error != 0 && error != EEXIST) return failure(not_written(path, "start a ledger", error));
  sync_ledger_folder(path);
  return {};
}

Expected<void> check_version(SqliteConnection& connection) {
  const Place place{connection.file(), 0, 0};
  PANELCAL_TRY(const std::int64_t application, connection.integer_of("PRAGMA application_id"));
  if (application != kLedgerApplicationId) {
    PANELCAL_TRY(const std::string schema, schema_of(connection));
    if (schema.find(kSchemaMark) != std::string::npos) {
      return failure({Code::LedgerCorrupt, place, "the file's header is damaged", "a ledger's"});
    }
    return failure({Code::LedgerForeign, place, "it is a database of another program", "a ledger"});
  }
  PANELCAL_TRY(const std::int64_t version, connection.integer_of("PRAGMA user_version"));
  if (version > kLedgerVersion) {
    return failure({Code::LedgerNewer,
                    place,
                    fmt::format("version {}", version),
                    fmt::format("at most {}", kLedgerVersion)});
  }
  if (version == kLedgerVersion) return {};
  return failure({Code::LedgerCorrupt, place, fmt::format("version {} is not known", version), ""});
}

Expected<std::unique_ptr<SqliteConnection>> open_ledger_file(const fs::path& path,
                                                             SqliteConnection::Mode mode,
                                                             const LedgerOptions& options) {
  PANELCAL_CHECK(check_exists(path));
  PANELCAL_TRY(std::unique_ptr<SqliteConnection> connection,
               SqliteConnection::open(path, mode, options.busy_timeout));
  bool is_ledger = false;
  const auto examine = [&]() -> Expected<void> {
    PANELCAL_CHECK(prepare_connection(*connection, mode));
    PANELCAL_CHECK(check_version(*connection));
    is_ledger = true;
    PANELCAL_CHECK(check_structure(*connection));
    if (mode == SqliteConnection::Mode::Write) PANELCAL_CHECK(check_journal_mode(*connection));
    return check_newest(*connection, options.n_checked);
  };
  const Expected<void> good = examine();
  if (good) return connection;
  connection.reset();
  // SQLite calls everything damaged that it cannot read, a text file too.
  const bool is_unclear = !is_ledger && good.error().code == Code::LedgerCorrupt;
  if (is_unclear && !is_wrecked_ledger(path)) {
    return failure(problem(Code::LedgerForeign, path, "", "a ledger"));
  }
  return failure(good.error());
}

Expected<fs::path> move_aside(const fs::path& path, const std::string& suffix) {
  // A link stays where it is and then leads nowhere, as if the file had been moved by hand.
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  if (error) real = path;
  constexpr int kMaxTries = 1000;
  for (int i = 1; i <= kMaxTries; ++i) {
    const std::string number = i == 1 ? "" : fmt::format("-{}", i);
    const fs::path aside = real.string() + suffix + number;
    const int failed = rename_to_free_name(real, aside);
    if (failed == EEXIST) continue;
    if (failed != 0) return failure(not_written(path, "move it aside", failed));
    // A journal left behind would be taken for one of the ledger that comes next.
    for (const std::string_view part : {"-journal", "-wal", "-shm"}) {
      rename_to_free_name(real.string() + std::string(part), aside.string() + std::string(part));
    }
    sync_ledger_folder(real);
    return aside;
  }
  return failure(not_written(path, "move it aside", EEXIST));
}

}  // namespace panelcal::internal
