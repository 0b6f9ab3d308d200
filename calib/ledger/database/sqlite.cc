// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/database/sqlite.h"

#include <system_error>
#include <utility>

#include <sqlite3.h>

namespace panelcal::internal {
namespace {

Diagnostic diagnostic_of(sqlite3* handle, const std::string& file) {
  const int extended = handle == nullptr ? SQLITE_NOMEM : sqlite3_extended_errcode(handle);
  const std::string words = handle == nullptr ? "out of memory" : sqlite3_errmsg(handle);
  const Place place{file, 0, 0};
  if (extended == SQLITE_READONLY_ROLLBACK || extended == SQLITE_READONLY_RECOVERY) {
    return {Code::FileUnreadable,
            place,
            "a write was interrupted and must be undone first",
            "opening it once where it can be written"};
  }
  switch (extended & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {Code::LedgerBusy, place, "another program holds the ledger", "it to be free"};
    // Our statements are right, so an error in one means that the file is not what they are for.
    case SQLITE_ERROR:
    case SQLITE_SCHEMA:
    case SQLITE_CONSTRAINT:
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_MISMATCH:
      return {Code::LedgerCorrupt, place, "the file is damaged: " + words, ""};
    case SQLITE_FULL:
      return {Code::DeviceWrite, place, "nothing was recorded: the disk is full", "free space"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {Code::DeviceWrite, place, "nothing was recorded: no permission", ""};
    case SQLITE_CANTOPEN:
      // Of an open database it is the journal that cannot be made.
      if (sqlite3_db_readonly(handle, "main") == 0) {
        return {
            Code::DeviceWrite, place, "nothing was recorded: cannot make a journal beside it", ""};
      }
      return {Code::FileUnreadable, place, "cannot open: " + words, "a readable file"};
    case SQLITE_IOERR: {
      if (extended == SQLITE_IOERR_READ) {
        return {Code::FileUnreadable, place, words, ""};
      }
      const int error = sqlite3_system_errno(handle);
      const std::string why = error == 0 ? words : std::generic_category().message(error);
      return {Code::DeviceWrite, place, "nothing was recorded: " + why, ""};
    }
    default:
      return {Code::Internal, place, "SQLite says: " + words, ""};
  }
}

}  // namespace

void SqliteStatement::Finalizer::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

SqliteStatement::SqliteStatement(sqlite3_stmt* statement, const std::string* file)
    : statement_(statement), file_(file) {
}

void SqliteStatement::bind(int i_parameter, std::string_view text) {
  sqlite3_bind_text64(statement_.get(),
                      i_parameter,
                      text.empty() ? "" : text.data(),
                      text.size(),
                      SQLITE_TRANSIENT,
                      SQLITE_UTF8);
}

void SqliteStatement::bind(int i_parameter, std::int64_t number) {
  sqlite3_bind_int64(statement_.get(), i_parameter, number);
}

void SqliteStatement::bind_number(int i_parameter, double number) {
  sqlite3_bind_double(statement_.get(), i_parameter, number);
}

void SqliteStatement::bind_null(int i_parameter) {
  sqlite3_bind_null(statement_.get(), i_parameter);
}

Expected<bool> SqliteStatement::step() {
  const int status = sqlite3_step(statement_.get());
  if (status == SQLITE_ROW) return true;
  if (status == SQLITE_DONE) return false;
  return failure(diagnostic_of(sqlite3_db_handle(statement_.get()), *file_));
}

void SqliteStatement::reset() {
  sqlite3_reset(statement_.get());
}

int SqliteStatement::n_columns() const {
  return sqlite3_column_count(statement_.get());
}

SqliteStatement::Kind SqliteStatement::kind(int i_column) const {
  switch (sqlite3_column_type(statement_.get(), i_column)) {
    case SQLITE_NULL:
      return Kind::Null;
    case SQLITE_INTEGER:
      return Kind::Integer;
    case SQLITE_FLOAT:
      return Kind::Number;
    default:
      return Kind::Text;
  }
}

double SqliteStatement::number(int i_column) const {
  return sqlite3_column_double(statement_.get(), i_column);
}

std::int64_t SqliteStatement::integer(int i_column) const {
  return sqlite3_column_int64(statement_.get(), i_column);
}

std::string_view SqliteStatement::text(int i_column) const {
  const void* bytes = sqlite3_column_blob(statement_.get(), i_column);
  const int n_bytes = sqlite3_column_bytes(statement_.get(), i_column);
  if (bytes == nullptr) return {};
  return {static_cast<const char*>(bytes), static_cast<std::size_t>(n_bytes)};
}

void SqliteConnection::Closer::operator()(sqlite3* handle) const {
  sqlite3_close(handle);
}

SqliteConnection::SqliteConnection(sqlite3* handle, std::string file)
    : file_(std::move(file)), handle_(handle) {
}

Expected<std::unique_ptr<SqliteConnection>> SqliteConnection::open(
    const std::filesystem::path& path, Mode mode, std::chrono::milliseconds busy_timeout) {
  // Absolute, so that no name means memory or a URI.
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  if (error) {
    return failure(
        {Code::FileUnreadable, {path.string(), 0, 0}, "cannot open: " + error.message(), ""});
  }
  const int flags = (mode == Mode::Write ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY) |
                    SQLITE_OPEN_PRIVATECACHE | SQLITE_OPEN_NOMUTEX;
  sqlite3* handle = nullptr;
  const int status = sqlite3_open_v2(absolute.c_str(), &handle, flags, nullptr);
  std::unique_ptr<SqliteConnection> connection(new SqliteConnection(handle, path.string()));
  if (status != SQLITE_OK) return failure(diagnostic_of(handle, connection->file_));
  // SQLite itself would go on with a file that can only be read.
  if (mode == Mode::Write && sqlite3_db_readonly(handle, "main") != 0) {
    return failure({Code::DeviceWrite, {path.string(), 0, 0}, "no permission", ""});
  }
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, static_cast<int>(busy_timeout.count()));
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  return connection;
}

Expected<void> SqliteConnection::run(const std::string& sql) {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return failure(diagnostic_of(handle_.get(), file_));
}

Expected<SqliteStatement> SqliteConnection::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int status = sqlite3_prepare_v2(
      handle_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  if (status != SQLITE_OK) return failure(diagnostic_of(handle_.get(), file_));
  return SqliteStatement(statement, &file_);
}

Expected<std::string> SqliteConnection::text_of(std::string_view sql) {
  PANELCAL_TRY(SqliteStatement statement, prepare(sql));
  PANELCAL_TRY(const bool has_row, statement.step());
  return has_row ? std::string(statement.text(0)) : std::string();
}

Expected<std::int64_t> SqliteConnection::integer_of(std::string_view sql) {
  PANELCAL_TRY(SqliteStatement statement, prepare(sql));
  PANELCAL_TRY(const bool has_row, statement.step());
  return has_row ? statement.integer(0) : 0;
}

bool SqliteConnection::in_transaction() const {
  return sqlite3_get_autocommit(handle_.get()) == 0;
}

bool SqliteConnection::has_moved() const {
  int moved = 0;
  sqlite3_file_control(handle_.get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  return moved != 0;
}

SqliteTransaction::SqliteTransaction(SqliteConnection& connection) : connection_(&connection) {
}

SqliteTransaction::SqliteTransaction(SqliteTransaction&& other) noexcept
    : connection_(std::exchange(other.connection_, nullptr)) {
}

SqliteTransaction::~SqliteTransaction() {
  // After some errors SQLite has rolled back by itself.
  if (connection_ == nullptr || !connection_->in_transaction()) return;
  static_cast<void>(connection_->run("ROLLBACK"));
}

Expected<SqliteTransaction> SqliteTransaction::begin(SqliteConnection& connection,
                                                     const std::string& sql) {
  PANELCAL_CHECK(connection.run(sql));
  return SqliteTransaction(connection);
}

Expected<void> SqliteTransaction::commit() {
  PANELCAL_CHECK(connection_->run("COMMIT"));
  connection_ = nullptr;
  return {};
}

}  // namespace panelcal::internal
