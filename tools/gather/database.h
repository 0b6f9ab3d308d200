// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "tools/batch/store/outcome.h"

namespace panelcal::gather {

using batch::StoredRow;
using batch::StoredValue;

/// A database that the results of many batches and the ledgers of many machines are gathered in: a
/// file of SQLite, or one of PostgreSQL's. Both take the same statements.
///
/// Fails  device-write: the database cannot be reached or written; usage: another program's
class Database {
 public:
  Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  virtual ~Database() = default;

  /// For messages: never with a password.
  virtual const std::string& name() const = 0;
  /// A statement without rows; each `?` stands for the next value.
  virtual Expected<void> run(std::string_view sql, std::span<const StoredValue> values = {}) = 0;
  /// All rows of a query.
  virtual Expected<std::vector<StoredRow>> rows(std::string_view sql,
                                                std::span<const StoredValue> values = {}) = 0;
  /// Waits until no other program of ours writes.
  virtual Expected<void> begin() = 0;
  virtual Expected<void> commit() = 0;
  virtual void roll_back() noexcept = 0;
};

/// Everything between its making and commit() happens, or nothing does.
class Transaction {
 public:
  static Expected<Transaction> begin(Database& database) {
    PANELCAL_CHECK(database.begin());
    return Transaction(database);
  }
  Transaction(Transaction&& other) noexcept : database_(std::exchange(other.database_, nullptr)) {}
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction() {
    if (database_ != nullptr) database_->roll_back();
  }

  Expected<void> commit() {
    PANELCAL_CHECK(database_->commit());
    database_ = nullptr;
    return {};
  }

 private:
  explicit Transaction(Database& database) : database_(&database) {}
  Database* database_;
};

/// Opens a database, makes it where there is none (of PostgreSQL's its tables), and brings its
/// tables to this version.
///
/// In     address: a file, or postgresql://USER@HOST/DATABASE as libpq takes it
/// Fails  device-write; usage (another program's, or one of a newer panelcal)
/// See    docs/formats/gathered.md; tests/tools/gather_test.py
Expected<std::unique_ptr<Database>> open_database(const std::string& address);

/// Without tables yet.
Expected<std::unique_ptr<Database>> open_sqlite(const std::string& file);
/// In a module of its own, as libpq is a suggestion and not a need.
Expected<std::unique_ptr<Database>> open_postgresql(const std::string& address);

}  // namespace panelcal::gather
