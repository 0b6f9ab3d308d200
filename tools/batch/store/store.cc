// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/store/store.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "calib/base/files/file_descriptor.h"
#include "calib/ledger/database/sqlite.h"
#include "tools/batch/store/schema.h"
#include "tools/batch/store/sqlite_values.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::batch {
namespace {

using internal::SqliteConnection;
using internal::SqliteStatement;
using internal::SqliteTransaction;

/// Longer than another program's query takes.
constexpr std::chrono::milliseconds kStoreTimeout{10'000};

template <class T>
Expected<T> of_store(Expected<T> value) {
  return of_database(std::move(value), "the store of a batch, whole");
}

std::string insertion(const StoreTable& table) {
  std::string marks = "?";
  for (int i = 1; i < table.n_columns; ++i) marks += ",?";
  return fmt::format("INSERT INTO {}({}) VALUES({})", table.name, table.columns, marks);
}

Expected<JobState> state_of(std::string_view text, const std::string& file) {
  for (const JobState state : {JobState::Drilled, JobState::Held, JobState::Failed}) {
    if (text == name(state)) return state;
  }
  return failure({Code::Usage, {file, 0, 0}, "state " + quoted(text), "drilled, held or failed"});
}

}  // namespace

std::string_view name(JobState state) {
  switch (state) {
    case JobState::Drilled:
      return "drilled";
    case JobState::Held:
      return "held";
    case JobState::Failed:
      break;
  }
  return "failed";
}

Store::Store(std::unique_ptr<SqliteConnection> connection) : connection_(std::move(connection)) {
}
Store::Store(Store&& other) noexcept = default;
Store::~Store() = default;

Expected<Store> Store::create(const std::filesystem::path& file, const StoredBatch& batch) {
  // An empty file is an empty database.
  const internal::FileDescriptor made(
      ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (made.get() < 0) {
    return failure({Code::DeviceWrite,
                    {file.string(), 0, 0},
                    "cannot create: " + std::generic_category().message(errno),
                    ""});
  }
  PANELCAL_TRY(
      auto connection,
      of_store(SqliteConnection::open(file, SqliteConnection::Mode::Write, kStoreTimeout)));
  Store store(std::move(connection));
  const std::string sql = fmt::format(
      "PRAGMA journal_mode=DELETE; PRAGMA synchronous=EXTRA; BEGIN; PRAGMA application_id={}; "
      "PRAGMA user_version={}; {}",
      kStoreApplicationId,
      kStoreVersion,
      kStoreSchema);
  PANELCAL_CHECK(of_store(store.connection_->run(sql)));
  const std::array<StoredValue, 6> values = {batch.panelcal,
                                             batch.manifest,
                                             batch.manifest_sha256,
                                             batch.terms,
                                             batch.clock,
                                             batch.n_jobs};
  PANELCAL_CHECK(store.run("INSERT INTO batch VALUES(?,?,?,?,?,?)", values));
  PANELCAL_CHECK(of_store(store.connection_->run("COMMIT")));
  return store;
}

Expected<void> Store::check_version() {
  const Place place{connection_->file(), 0, 0};
  PANELCAL_TRY(const std::int64_t id, of_store(connection_->integer_of("PRAGMA application_id")));
  PANELCAL_TRY(const std::int64_t version,
               of_store(connection_->integer_of("PRAGMA user_version")));
  if (id != kStoreApplicationId) {
    return failure({Code::Usage, place, "no store of a batch", "the folder of `batch -o`"});
  }
  if (version == kStoreVersion) return {};
  return failure({Code::Usage,
                  place,
                  fmt::format("version {} of the store", version),
                  fmt::format("version {}, or another panelcal", kStoreVersion)});
}

Expected<Store> Store::open(const std::filesystem::path& file) {
  PANELCAL_TRY(
      auto connection,
      of_store(SqliteConnection::open(file, SqliteConnection::Mode::Write, kStoreTimeout)));
  Store store(std::move(connection));
  PANELCAL_CHECK(store.check_version());
  PANELCAL_CHECK(of_store(store.connection_->run("PRAGMA synchronous=EXTRA")));
  return store;
}

Expected<Store> Store::open_to_read(const std::filesystem::path& file) {
  const auto open_so = [&]() -> Expected<Store> {
    PANELCAL_TRY(
        auto connection,
        of_store(SqliteConnection::open(file, SqliteConnection::Mode::Read, kStoreTimeout)));
    Store store(std::move(connection));
    PANELCAL_CHECK(store.check_version());
    return store;
  };
  auto store = open_so();
  if (store) return store;
  // What a killed batch was writing has to be undone first, which only a writer can.
  auto writer = open(file);
  return writer ? std::move(writer) : std::move(store);
}

Expected<StoredBatch> Store::batch() {
  PANELCAL_TRY(const std::vector<StoredRow> found,
               rows("SELECT panelcal, manifest, manifest_sha256, terms, clock, n_jobs FROM batch"));
  if (found.size() != 1) {
    return failure({Code::Usage, {connection_->file(), 0, 0}, "no batch in it", "one"});
  }
  const auto text = [&](std::size_t i) { return std::get<std::string>(found[0][i]); };
  return StoredBatch{
      text(0), text(1), text(2), text(3), text(4), std::get<std::int64_t>(found[0][5])};
}

Expected<std::vector<std::optional<JobState>>> Store::states(std::int64_t n_jobs) {
  std::vector<std::optional<JobState>> out(static_cast<std::size_t>(n_jobs));
  PANELCAL_TRY(SqliteStatement found,
               of_store(connection_->prepare("SELECT number, state FROM job")));
  while (true) {
    PANELCAL_TRY(const bool has_row, of_store(found.step()));
    if (!has_row) return out;
    const std::int64_t number = found.integer(0);
    PANELCAL_TRY(const JobState state, state_of(found.text(1), connection_->file()));
    if (number >= 1 && number <= n_jobs) out[static_cast<std::size_t>(number - 1)] = state;
  }
}

Expected<std::int64_t> Store::begin_session(const StoredSession& session) {
  const std::array<StoredValue, 2> values = {session.started, session.n_threads};
  PANELCAL_CHECK(
      run("INSERT INTO session(started, threads, n_jobs, n_pictures, seconds) VALUES(?,?,0,0,0)",
          values));
  return of_store(connection_->integer_of("SELECT max(number) FROM session"));
}

Expected<void> Store::put(std::span<const JobOutcome> jobs,
                          std::int64_t i_session,
                          const StoredSession& session) {
  PANELCAL_TRY(SqliteTransaction transaction, of_store(SqliteTransaction::begin(*connection_)));
  for (const JobOutcome& job : jobs) PANELCAL_CHECK(put_job(job));
  const std::array<StoredValue, 4> values = {
      session.n_jobs, session.n_pictures, session.seconds, i_session};
  PANELCAL_CHECK(
      run("UPDATE session SET n_jobs=?, n_pictures=?, seconds=? WHERE number=?", values));
  return of_store(transaction.commit());
}

Expected<void> Store::put_job(const JobOutcome& job) {
  for (std::size_t i = 0; i < kStoreTables.size(); ++i) {
    const StoreTable& table = kStoreTables[i];
    const std::string_view key = i == 0 ? "number" : "job";
    PANELCAL_TRY(SqliteStatement* const deletion,
                 statement(2 * i, fmt::format("DELETE FROM {} WHERE {}=?", table.name, key)));
    deletion->reset();
    deletion->bind(1, job.number);
    PANELCAL_TRY(const bool ignored, of_store(deletion->step()));
    static_cast<void>(ignored);
    PANELCAL_TRY(SqliteStatement* const insert, statement(2 * i + 1, insertion(table)));
    for (const StoredRow& row : job.rows[i]) {
      insert->reset();
      for (std::size_t k = 0; k < row.size(); ++k) bind(*insert, static_cast<int>(k) + 1, row[k]);
      PANELCAL_TRY(const bool has_row, of_store(insert->step()));
      static_cast<void>(has_row);
    }
    insert->reset();
    deletion->reset();
  }
  return {};
}

Expected<std::int64_t> Store::take_in(const std::filesystem::path& part) {
  std::error_code error;
  const std::array<StoredValue, 1> name = {std::filesystem::absolute(part, error).string()};
  PANELCAL_CHECK(run("ATTACH DATABASE ? AS part", name));
  // Not immediate: that would write to the part as well, and a kill leave a journal of both.
  PANELCAL_TRY(SqliteTransaction transaction,
               of_store(SqliteTransaction::begin(*connection_, "BEGIN")));
  for (const StoreTable& table : kStoreTables) {
    const std::string_view key = table.name == "job" ? "number" : "job";
    PANELCAL_CHECK(of_store(connection_->run(
        fmt::format("DELETE FROM main.{0} WHERE {1} IN (SELECT number FROM part.job); "
                    "INSERT INTO main.{0}({2}) SELECT {2} FROM part.{0} ORDER BY 1, 2",
                    table.name,
                    key,
                    table.columns))));
  }
  // Their time alone tells sessions apart, and is the same only if it is the same session.
  PANELCAL_CHECK(of_store(connection_->run(
      "INSERT INTO main.session(started, threads, n_jobs, n_pictures, seconds) "
      "SELECT started, threads, n_jobs, n_pictures, seconds FROM part.session EXCEPT "
      "SELECT started, threads, n_jobs, n_pictures, seconds FROM main.session")));
  PANELCAL_CHECK(of_store(transaction.commit()));
  PANELCAL_TRY(const std::int64_t n_jobs,
               of_store(connection_->integer_of("SELECT count(*) FROM part.job")));
  PANELCAL_CHECK(of_store(connection_->run("DETACH DATABASE part")));
  return n_jobs;
}

Expected<SqliteStatement*> Store::statement(std::size_t i, const std::string& sql) {
  statements_.resize(2 * kStoreTables.size());
  if (statements_[i] == nullptr) {
    PANELCAL_TRY(SqliteStatement made, of_store(connection_->prepare(sql)));
    statements_[i] = std::make_unique<SqliteStatement>(std::move(made));
  }
  return statements_[i].get();
}

Expected<void> Store::run(std::string_view sql, std::span<const StoredValue> values) {
  PANELCAL_TRY(SqliteStatement made, of_store(connection_->prepare(sql)));
  for (std::size_t i = 0; i < values.size(); ++i) bind(made, static_cast<int>(i) + 1, values[i]);
  PANELCAL_TRY(const bool has_row, of_store(made.step()));
  static_cast<void>(has_row);
  return {};
}

Expected<void> Store::each(std::string_view sql,
                           const std::function<void(const StoredRow&)>& take) {
  PANELCAL_TRY(SqliteStatement made, of_store(connection_->prepare(sql)));
  while (true) {
    PANELCAL_TRY(const bool has_row, of_store(made.step()));
    if (!has_row) return {};
    take(row_of(made));
  }
}

Expected<std::vector<StoredRow>> Store::rows(std::string_view sql) {
  std::vector<StoredRow> out;
  PANELCAL_CHECK(each(sql, [&out](const StoredRow& row) { out.push_back(row); }));
  return out;
}

}  // namespace panelcal::batch
