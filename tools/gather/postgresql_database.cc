// SPDX-License-Identifier: Apache-2.0
// PostgreSQL by libpq: in a module of its own (tools/modules/postgresql_module.cc).
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include "calib/base/json/utf8.h"
#include "tools/gather/address.h"
#include "tools/gather/database.h"
#include <fmt/format.h>
#include <libpq-fe.h>

namespace panelcal::gather {
namespace {

/// Tables of ours stand in a schema of their own, beside whatever else the database has.
constexpr const char* kBegin =
    "SET client_min_messages = warning; CREATE SCHEMA IF NOT EXISTS panelcal; "
    "SET search_path TO panelcal";
/// "PCBG": one writer at a time, as with SQLite.
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(1346585159)";

/// pg_type.h: the types of our columns, and what functions make of them.
constexpr Oid kInt8 = 20, kInt4 = 23, kInt2 = 21, kFloat8 = 701, kNumeric = 1700;

struct Finisher {
  void operator()(PGconn* connection) const { PQfinish(connection); }
  void operator()(PGresult* result) const { PQclear(result); }
};
using Connection = std::unique_ptr<PGconn, Finisher>;
using Result = std::unique_ptr<PGresult, Finisher>;

/// `?` to `$1`, `$2`, ...: our statements have no other question marks.
std::string numbered(std::string_view sql) {
  std::string out;
  int i = 0;
  for (const char c : sql) {
    if (c == '?') {
      out += fmt::format("${}", ++i);
    } else {
      out += c;
    }
  }
  return out;
}

/// PostgreSQL takes UTF-8 without NUL, and names of files may hold anything: as JSON has them.
std::string as_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t n = utf8_length(text);
    if (n == 0 || text.front() == '\0') {
      out += "\xEF\xBF\xBD";
      text.remove_prefix(1);
    } else {
      out += text.substr(0, n);
      text.remove_prefix(n);
    }
  }
  return out;
}

/// In PostgreSQL's text form; empty: NULL.
std::optional<std::string> parameter_text(const StoredValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value); number && std::isfinite(*number)) {
    return fmt::format("{}", *number);
  }
  if (const auto* text = std::get_if<std::string>(&value)) return as_utf8(*text);
  return std::nullopt;
}

StoredValue value_of(const PGresult& result, int i_row, int i_column) {
  if (PQgetisnull(&result, i_row, i_column) != 0) return {};
  const std::string_view text(PQgetvalue(&result, i_row, i_column),
                              static_cast<std::size_t>(PQgetlength(&result, i_row, i_column)));
  const char* const end = text.data() + text.size();
  switch (PQftype(&result, i_column)) {
    case kInt2:
    case kInt4:
    case kInt8: {
      std::int64_t whole = 0;
      std::from_chars(text.data(), end, whole);
      return whole;
    }
    case kFloat8:
    case kNumeric: {
      double number = 0;
      std::from_chars(text.data(), end, number);
      return number;
    }
    default:
      return std::string(text);
  }
}

/// libpq ends its messages by a line feed, and may have several lines.
std::string first_line(std::string_view text) {
  return std::string(text.substr(0, text.find('\n')));
}

class PostgresqlDatabase final : public Database {
 public:
  PostgresqlDatabase(Connection connection, std::string name)
      : connection_(std::move(connection)), name_(std::move(name)) {}

  const std::string& name() const override { return name_; }

  Expected<void> run(std::string_view sql, std::span<const StoredValue> values) override {
    PANELCAL_TRY(const Result result, executed(sql, values));
    return {};
  }

  Expected<std::vector<StoredRow>> rows(std::string_view sql,
                                        std::span<const StoredValue> values) override {
    PANELCAL_TRY(const Result result, executed(sql, values));
    std::vector<StoredRow> out(static_cast<std::size_t>(PQntuples(result.get())));
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (int k = 0; k < PQnfields(result.get()); ++k) {
        out[i].push_back(value_of(*result, static_cast<int>(i), k));
      }
    }
    return out;
  }

  Expected<void> begin() override {
    PANELCAL_CHECK(run("BEGIN", {}));
    return run(kLock, {});
  }
  Expected<void> commit() override { return run("COMMIT", {}); }
  void roll_back() noexcept override {
    if (PQtransactionStatus(connection_.get()) != PQTRANS_IDLE) {
      static_cast<void>(run("ROLLBACK", {}));
    }
  }

  Expected<Result> executed(std::string_view sql, std::span<const StoredValue> values) {
    Result result;
    if (values.empty()) {
      // Several statements at once, too.
      result.reset(PQexec(connection_.get(), std::string(sql).c_str()));
    } else {
      std::vector<std::optional<std::string>> texts;
      std::vector<const char*> parameters;
      for (const StoredValue& value : values) texts.push_back(parameter_text(value));
      for (const auto& text : texts) parameters.push_back(text ? text->c_str() : nullptr);
      result.reset(PQexecParams(connection_.get(),
                                numbered(sql).c_str(),
                                static_cast<int>(parameters.size()),
                                nullptr,
                                parameters.data(),
                                nullptr,
                                nullptr,
                                0));
    }
    const ExecStatusType status = PQresultStatus(result.get());
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return result;
    return failure(
        {Code::DeviceWrite,
         {name_, 0, 0},
         "the database refuses or is gone: " + first_line(PQerrorMessage(connection_.get())),
         "a database that may be written, then the same command again"});
  }

 private:
  Connection connection_;
  std::string name_;
};

}  // namespace

Expected<std::unique_ptr<Database>> open_postgresql(const std::string& address) {
  // Of the same name the later one counts, so that the address may say otherwise of these.
  constexpr std::array<const char*, 5> kKeys = {
      "connect_timeout", "application_name", "client_encoding", "dbname", nullptr};
  const std::array<const char*, 5> values = {"10", "panelcal", "UTF8", address.c_str(), nullptr};
  Connection connection(PQconnectdbParams(kKeys.data(), values.data(), 1));
  const std::string name = without_database_password(address);
  if (PQstatus(connection.get()) != CONNECTION_OK) {
    std::string why = first_line(PQerrorMessage(connection.get()));
    // An address that it cannot read is repeated.
    if (const std::size_t at = why.find(address); at != std::string::npos) {
      why.replace(at, address.size(), name);
    }
    return failure({Code::DeviceWrite,
                    {name, 0, 0},
                    "cannot connect: " + why,
                    "a server that runs, and a user that it knows (PGPASSFILE has passwords)"});
  }
  auto database = std::make_unique<PostgresqlDatabase>(std::move(connection), name);
  PANELCAL_CHECK(database->run(kBegin, {}));
  return database;
}

}  // namespace panelcal::gather
