// SPDX-License-Identifier: Apache-2.0
#include "tools/gather/jobs.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "calib/base/files/digest.h"
#include "tools/batch/store/schema.h"
#include "tools/gather/insertion.h"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace panelcal::gather {
namespace {

using batch::kStoreTables;

/// Jobs of a transaction: a server answers in the time of hundreds of rows.
constexpr std::size_t kJobsAtOnce = 200;

/// The rows of a job in each of the tables.
struct Job {
  std::array<std::vector<StoredRow>, kStoreTables.size()> rows;
  std::string sha256;
};
using Jobs = std::map<std::int64_t, Job>;

/// Every value with its kind, so that no two rows have the same text.
std::string canonical_text(const StoredValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return fmt::format("i{};", *whole);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("n{};", *number);
  if (const auto* text = std::get_if<std::string>(&value)) {
    return fmt::format("t{}:{};", text->size(), *text);
  }
  return "-;";
}

std::string digest_of(const Job& job) {
  std::string text;
  for (const std::vector<StoredRow>& rows : job.rows) {
    for (const StoredRow& row : rows) {
      for (const StoredValue& value : row) text += canonical_text(value);
      text += '\n';
    }
    text += '\n';
  }
  return sha256(text);
}

std::string list_of(std::span<const std::int64_t> numbers) {
  return fmt::format("{}", fmt::join(numbers, ","));
}

Expected<Jobs> jobs_of(batch::Store& store, std::span<const std::int64_t> numbers) {
  Jobs jobs;
  for (std::size_t i = 0; i < kStoreTables.size(); ++i) {
    const std::string_view key = i == 0 ? "number" : "job";
    PANELCAL_CHECK(store.each(fmt::format("SELECT {} FROM {} WHERE {} IN ({}) ORDER BY 1, 2",
                                          kStoreTables[i].columns,
                                          kStoreTables[i].name,
                                          key,
                                          list_of(numbers)),
                              [&](const StoredRow& row) {
                                jobs[std::get<std::int64_t>(row.front())].rows[i].push_back(row);
                              }));
  }
  for (auto& [number, job] : jobs) job.sha256 = digest_of(job);
  return jobs;
}

/// The factors of a job's row, a row each: not every database looks into JSON in the same way.
std::vector<StoredRow> factors_of(const std::string& id, const StoredRow& job) {
  std::vector<StoredRow> rows;
  const auto* text = std::get_if<std::string>(&job.back());
  const auto factors = nlohmann::json::parse(text == nullptr ? "" : *text, nullptr, false);
  if (!factors.is_object()) return rows;
  for (const auto& [name, value] : factors.items()) {
    const std::string words = value.is_string() ? value.get<std::string>() : value.dump();
    rows.push_back({id, job.front(), name, words});
  }
  return rows;
}

Expected<void> put_jobs(Database& database, const std::string& id, const Jobs& jobs) {
  std::vector<std::int64_t> numbers;
  for (const auto& [number, job] : jobs) numbers.push_back(number);
  const std::string list = list_of(numbers);
  const StoredValue values[] = {id};
  PANELCAL_TRY(Transaction transaction, Transaction::begin(database));
  constexpr std::string_view kFactor = "factor";
  std::vector<std::string_view> tables = {kFactor};
  for (std::size_t i = kStoreTables.size(); i > 0; --i) tables.push_back(kStoreTables[i - 1].name);
  for (const std::string_view table : tables) {
    const std::string_view key = table == "job" ? "number" : "job";
    PANELCAL_CHECK(database.run(
        fmt::format("DELETE FROM {} WHERE batch = ? AND {} IN ({})", table, key, list), values));
  }
  std::vector<StoredRow> factors;
  for (std::size_t i = 0; i < kStoreTables.size(); ++i) {
    std::vector<StoredRow> rows;
    for (const auto& [number, job] : jobs) {
      for (const StoredRow& row : job.rows[i]) {
        if (i == 0) std::ranges::move(factors_of(id, row), std::back_inserter(factors));
        StoredRow& whole = rows.emplace_back(StoredRow{id});
        whole.insert(whole.end(), row.begin(), row.end());
        if (i == 0) whole.emplace_back(job.sha256);
      }
    }
    const std::string columns =
        fmt::format("batch, {}{}", kStoreTables[i].columns, i == 0 ? ", sha256" : "");
    PANELCAL_CHECK(insert(database, kStoreTables[i].name, columns, rows));
  }
  PANELCAL_CHECK(insert(database, kFactor, "batch, job, name, value", factors));
  return transaction.commit();
}

}  // namespace

std::string batch_id(const batch::StoredBatch& batch) {
  return sha256(fmt::format("{}\n{}\n{}\n{}\n{}",
                            batch.panelcal,
                            batch.manifest_sha256,
                            batch.terms,
                            batch.clock,
                            batch.n_jobs));
}

JobDelivery::JobDelivery(std::unique_ptr<Database> database, batch::Store& store, std::string id)
    : database_(std::move(database)), store_(&store), id_(std::move(id)) {
}

Expected<JobDelivery> JobDelivery::begin(const std::string& address, batch::Store& store) {
  PANELCAL_TRY(std::unique_ptr<Database> database, open_database(address));
  PANELCAL_TRY(const batch::StoredBatch batch, store.batch());
  JobDelivery delivery(std::move(database), store, batch_id(batch));
  const StoredValue values[] = {delivery.id_,
                                batch.panelcal,
                                batch.manifest,
                                batch.manifest_sha256,
                                batch.terms,
                                batch.clock,
                                batch.n_jobs};
  PANELCAL_CHECK(delivery.database_->run(
      "INSERT INTO batch(id, panelcal, manifest, manifest_sha256, terms, clock, n_jobs) "
      "VALUES(?,?,?,?,?,?,?) ON CONFLICT(id) DO NOTHING",
      values));
  return delivery;
}

Expected<std::int64_t> JobDelivery::deliver(std::span<const std::int64_t> numbers) {
  std::int64_t n_put = 0;
  while (!numbers.empty()) {
    const auto some = numbers.first(std::min(numbers.size(), kJobsAtOnce));
    PANELCAL_TRY(const std::int64_t n, deliver_some(some));
    n_put += n;
    numbers = numbers.subspan(some.size());
  }
  return n_put;
}

Expected<std::int64_t> JobDelivery::deliver_all() {
  std::vector<std::int64_t> numbers;
  PANELCAL_CHECK(store_->each("SELECT number FROM job ORDER BY 1", [&](const StoredRow& row) {
    numbers.push_back(std::get<std::int64_t>(row.front()));
  }));
  return deliver(numbers);
}

Expected<std::int64_t> JobDelivery::deliver_some(std::span<const std::int64_t> numbers) {
  PANELCAL_TRY(Jobs jobs, jobs_of(*store_, numbers));
  const StoredValue values[] = {id_};
  PANELCAL_TRY(const std::vector<StoredRow> present,
               database_->rows(
                   fmt::format("SELECT number, sha256 FROM job WHERE batch = ? AND number IN ({})",
                               list_of(numbers)),
                   values));
  for (const StoredRow& row : present) {
    const auto job = jobs.find(std::get<std::int64_t>(row[0]));
    if (job != jobs.end() && row[1] == StoredValue(job->second.sha256)) jobs.erase(job);
  }
  if (jobs.empty()) return 0;
  PANELCAL_CHECK(put_jobs(*database_, id_, jobs));
  return static_cast<std::int64_t>(jobs.size());
}

}  // namespace panelcal::gather
