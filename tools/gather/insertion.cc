// SPDX-License-Identifier: Apache-2.0
#include "tools/gather/insertion.h"

#include <fmt/format.h>

namespace panelcal::gather {

Expected<void> insert(Database& database,
                      std::string_view table,
                      std::string_view columns,
                      std::span<const StoredRow> rows) {
  // SQLite takes 32,766 values a statement, PostgreSQL 65,535.
  constexpr std::size_t kMaxValues = 8192;
  while (!rows.empty()) {
    const std::size_t n_columns = rows.front().size();
    const std::span<const StoredRow> now =
        rows.first(std::clamp<std::size_t>(kMaxValues / n_columns, 1, rows.size()));
    std::string marks = "(?";
    for (std::size_t i = 1; i < n_columns; ++i) marks += ",?";
    marks += ')';
    std::string sql = fmt::format("INSERT INTO {}({}) VALUES {}", table, columns, marks);
    for (std::size_t i = 1; i < now.size(); ++i) sql += "," + marks;
    std::vector<StoredValue> values;
    values.reserve(now.size() * n_columns);
    for (const StoredRow& row : now) values.insert(values.end(), row.begin(), row.end());
    PANELCAL_CHECK(database.run(sql, values));
    rows = rows.subspan(now.size());
  }
  return {};
}

}  // namespace panelcal::gather
