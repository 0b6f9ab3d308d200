// SPDX-License-Identifier: Apache-2.0
#include "tools/gather/database.h"

#include <cstdint>

#include "tools/gather/address.h"
#include "tools/gather/schema.h"
#include <fmt/format.h>

namespace panelcal::gather {
namespace {

Expected<std::int64_t> version_of(Database& database) {
  PANELCAL_CHECK(database.run("CREATE TABLE IF NOT EXISTS version(number BIGINT NOT NULL)"));
  PANELCAL_TRY(const std::vector<StoredRow> found, database.rows("SELECT number FROM version"));
  if (found.empty()) return 0;
  const auto* number = std::get_if<std::int64_t>(&found.front().front());
  return number == nullptr ? -1 : *number;
}

Expected<void> migrate(Database& database) {
  PANELCAL_TRY(Transaction transaction, Transaction::begin(database));
  PANELCAL_TRY(const std::int64_t version, version_of(database));
  constexpr auto kNewest = static_cast<std::int64_t>(kMigrations.size());
  if (version < 0 || version > kNewest) {
    return failure({Code::Usage,
                    {database.name(), 0, 0},
                    fmt::format("version {} of the database", version),
                    fmt::format("version {} or an older one, or a newer panelcal", kNewest)});
  }
  if (version == kNewest) return {};
  for (auto i = static_cast<std::size_t>(version); i < kMigrations.size(); ++i) {
    PANELCAL_CHECK(database.run(kMigrations[i]));
  }
  PANELCAL_CHECK(database.run("DELETE FROM version"));
  const StoredValue values[] = {kNewest};
  PANELCAL_CHECK(database.run("INSERT INTO version VALUES(?)", values));
  return transaction.commit();
}

}  // namespace

Expected<std::unique_ptr<Database>> open_database(const std::string& address) {
  PANELCAL_TRY(std::unique_ptr<Database> database,
               is_postgresql(address) ? open_postgresql(address) : open_sqlite(address));
  PANELCAL_CHECK(migrate(*database));
  return database;
}

}  // namespace panelcal::gather
