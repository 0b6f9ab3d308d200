// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "calib/base/expected.h"

struct sqlite3;
struct sqlite3_stmt;

// Not installed: public headers know nothing of SQLite.
namespace panelcal::internal {

/// One prepared statement; texts that it returns live until its next step.
class SqliteStatement {
 public:
  void bind(int i_parameter, std::string_view text);
  void bind(int i_parameter, std::int64_t number);
  void bind_number(int i_parameter, double number);
  void bind_null(int i_parameter);

  /// True for a row, false at the end.
  Expected<bool> step();
  /// Ready to run again, with new values.
  void reset();

  enum class Kind : std::uint8_t { Null, Integer, Number, Text };
  int n_columns() const;
  Kind kind(int i_column) const;
  bool is_null(int i_column) const { return kind(i_column) == Kind::Null; }
  double number(int i_column) const;
  std::int64_t integer(int i_column) const;
  std::string_view text(int i_column) const;

 private:
  friend class SqliteConnection;
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const;
  };
  SqliteStatement(sqlite3_stmt* statement, const std::string* file);

  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
  const std::string* file_;
};

/// One connection to a database that exists.
///
/// Fails  ledger-corrupt (the file is damaged, or not as our statements need it); ledger-busy;
///        device-write (full disk, no permission, a failing device); file-unreadable
class SqliteConnection {
 public:
  enum class Mode : std::uint8_t { Read, Write };

  static Expected<std::unique_ptr<SqliteConnection>> open(const std::filesystem::path& path,
                                                          Mode mode,
                                                          std::chrono::milliseconds busy_timeout);
  SqliteConnection(const SqliteConnection&) = delete;
  SqliteConnection& operator=(const SqliteConnection&) = delete;

  Expected<void> run(const std::string& sql);
  Expected<SqliteStatement> prepare(std::string_view sql);
  /// The first column of the first row.
  Expected<std::string> text_of(std::string_view sql);
  Expected<std::int64_t> integer_of(std::string_view sql);

  bool in_transaction() const;
  /// True if another file stands under the name by now, or no file.
  bool has_moved() const;
  const std::string& file() const { return file_; }

 private:
  struct Closer {
    void operator()(sqlite3* handle) const;
  };
  SqliteConnection(sqlite3* handle, std::string file);

  std::string file_;
  std::unique_ptr<sqlite3, Closer> handle_;
};

/// BEGIN IMMEDIATE, so that what is read inside still holds when it commits; rolls back unless
/// committed.
class SqliteTransaction {
 public:
  static Expected<SqliteTransaction> begin(SqliteConnection& connection,
                                           const std::string& sql = "BEGIN IMMEDIATE");
  SqliteTransaction(SqliteTransaction&& other) noexcept;
  SqliteTransaction& operator=(SqliteTransaction&&) = delete;
  ~SqliteTransaction();

  Expected<void> commit();

 private:
  explicit SqliteTransaction(SqliteConnection& connection);
  SqliteConnection* connection_;
};

}  // namespace panelcal::internal
