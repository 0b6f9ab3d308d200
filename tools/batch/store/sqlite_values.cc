// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/store/sqlite_values.h"

#include <cmath>
#include <cstdint>
#include <string>

namespace panelcal::batch {

using internal::SqliteStatement;

void bind(SqliteStatement& statement, int i, const StoredValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    statement.bind(i, *whole);
  } else if (const auto* number = std::get_if<double>(&value); number && std::isfinite(*number)) {
    statement.bind_number(i, *number);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    statement.bind(i, *text);
  } else {
    statement.bind_null(i);
  }
}

StoredRow row_of(const SqliteStatement& statement) {
  StoredRow row;
  for (int i = 0; i < statement.n_columns(); ++i) {
    switch (statement.kind(i)) {
      case SqliteStatement::Kind::Null:
        row.emplace_back();
        break;
      case SqliteStatement::Kind::Integer:
        row.emplace_back(statement.integer(i));
        break;
      case SqliteStatement::Kind::Number:
        row.emplace_back(statement.number(i));
        break;
      case SqliteStatement::Kind::Text:
        row.emplace_back(std::string(statement.text(i)));
        break;
    }
  }
  return row;
}

Diagnostic of_database(Diagnostic problem, std::string_view whole) {
  switch (problem.code) {
    case Code::LedgerBusy:
      return {Code::DeviceWrite, problem.place, "another program has locked it", "it to be free"};
    case Code::LedgerCorrupt:
      return {Code::Usage, problem.place, problem.what, std::string(whole)};
    default:
      return problem;
  }
}

}  // namespace panelcal::batch
