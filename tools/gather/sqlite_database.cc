// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <chrono>
#include <system_error>

#include "calib/base/files/file_descriptor.h"
#include "calib/ledger/database/sqlite.h"
#include "tools/batch/store/sqlite_values.h"
#include "tools/gather/database.h"
#include <fcntl.h>
#include <fmt/format.h>

namespace panelcal::gather {
namespace {

using internal::SqliteConnection;
using internal::SqliteStatement;

/// "PCBG", in the file's header.
constexpr std::int64_t kApplicationId = 0x50434247;
/// Longer than another program's transaction takes.
constexpr std::chrono::milliseconds kTimeout{60'000};

template <class T>
Expected<T> checked(Expected<T> value) {
  return batch::of_database(std::move(value), "a database of --store, whole");
}

class SqliteDatabase final : public Database {
 public:
  explicit SqliteDatabase(std::unique_ptr<SqliteConnection> connection)
      : connection_(std::move(connection)) {}

  const std::string& name() const override { return connection_->file(); }

  Expected<void> run(std::string_view sql, std::span<const StoredValue> values) override {
    // Several statements at once, which have no values.
    if (values.empty()) return checked(connection_->run(std::string(sql)));
    PANELCAL_TRY(SqliteStatement made, prepared(sql, values));
    PANELCAL_TRY(const bool has_row, checked(made.step()));
    static_cast<void>(has_row);
    return {};
  }

  Expected<std::vector<StoredRow>> rows(std::string_view sql,
                                        std::span<const StoredValue> values) override {
    PANELCAL_TRY(SqliteStatement made, prepared(sql, values));
    std::vector<StoredRow> out;
    while (true) {
      PANELCAL_TRY(const bool has_row, checked(made.step()));
      if (!has_row) return out;
      out.push_back(batch::row_of(made));
    }
  }

  Expected<void> begin() override { return run("BEGIN IMMEDIATE", {}); }
  Expected<void> commit() override { return run("COMMIT", {}); }
  void roll_back() noexcept override {
    if (connection_->in_transaction()) static_cast<void>(run("ROLLBACK", {}));
  }

  Expected<void> check_ours() {
    PANELCAL_TRY(const std::int64_t id, checked(connection_->integer_of("PRAGMA application_id")));
    if (id == kApplicationId) return {};
    PANELCAL_TRY(const std::int64_t n_tables,
                 checked(connection_->integer_of("SELECT count(*) FROM sqlite_master")));
    if (id != 0 || n_tables != 0) {
      return failure({Code::Usage,
                      {name(), 0, 0},
                      "a database of something else",
                      "one of --store, or a new file"});
    }
    return run(fmt::format("PRAGMA application_id={}", kApplicationId), {});
  }

 private:
  Expected<SqliteStatement> prepared(std::string_view sql, std::span<const StoredValue> values) {
    PANELCAL_TRY(SqliteStatement made, checked(connection_->prepare(sql)));
    for (std::size_t i = 0; i < values.size(); ++i) {
      batch::bind(made, static_cast<int>(i) + 1, values[i]);
    }
    return made;
  }

  std::unique_ptr<SqliteConnection> connection_;
};

}  // namespace

Expected<std::unique_ptr<Database>> open_sqlite(const std::string& file) {
  // An empty file is an empty database.
  const internal::FileDescriptor made(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (made.get() < 0) {
    return failure({Code::DeviceWrite,
                    {file, 0, 0},
                    "cannot open: " + std::generic_category().message(errno),
                    "a file that may be written"});
  }
  PANELCAL_TRY(auto connection,
               checked(SqliteConnection::open(file, SqliteConnection::Mode::Write, kTimeout)));
  auto database = std::make_unique<SqliteDatabase>(std::move(connection));
  PANELCAL_CHECK(database->check_ours());
  PANELCAL_CHECK(database->run("PRAGMA foreign_keys=ON; PRAGMA synchronous=EXTRA", {}));
  return database;
}

}  // namespace panelcal::gather
