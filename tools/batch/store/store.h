// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "tools/batch/store/outcome.h"

namespace panelcal::internal {
class SqliteConnection;
class SqliteStatement;
}  // namespace panelcal::internal

namespace panelcal::batch {

/// The one batch that a store is of.
struct StoredBatch {
  std::string panelcal;  ///< the version that began it
  std::string manifest;
  std::string manifest_sha256;
  std::string terms;  ///< options that decide what comes out: the same batch has the same
  std::string clock;  ///< the time on the wall of its jobs
  std::int64_t n_jobs = 0;
};

/// One start of the process, as far as it has come.
struct StoredSession {
  std::string started;  ///< ISO 8601, UTC
  std::int64_t n_threads = 0;
  std::int64_t n_jobs = 0;
  std::int64_t n_pictures = 0;
  double seconds = 0;
};

/// The results of a batch: store.sqlite in its folder, with a rollback journal.
///
/// Fails  device-write (disk, permissions, another program has locked it); file-unreadable; usage
///        (no store of a batch, or one of a newer panelcal; a damaged one)
/// See    tests/tools/batch_test.py; docs/formats/store.md
class Store {
 public:
  static constexpr std::string_view kFileName = "store.sqlite";

  /// Makes an empty one; there must be none.
  static Expected<Store> create(const std::filesystem::path& file, const StoredBatch& batch);
  static Expected<Store> open(const std::filesystem::path& file);
  /// Opens it for queries alone.
  static Expected<Store> open_to_read(const std::filesystem::path& file);
  Store(Store&& other) noexcept;
  ~Store();

  Expected<StoredBatch> batch();
  /// The states of all jobs that are there, by their numbers less one.
  Expected<std::vector<std::optional<JobState>>> states(std::int64_t n_jobs);
  /// The row of a new session.
  Expected<std::int64_t> begin_session(const StoredSession& session);
  /// Puts jobs in, in the place of what is there of them, and how far the session is: all or
  /// nothing, and on disk when it returns.
  Expected<void> put(std::span<const JobOutcome> jobs,
                     std::int64_t i_session,
                     const StoredSession& session);
  /// Puts in everything that the store of a part of the batch has, in the place of what is there
  /// of the same jobs: all or nothing; a second time changes nothing.
  ///
  /// Out    the number of jobs
  Expected<std::int64_t> take_in(const std::filesystem::path& part);
  /// Calls with each row of a query.
  Expected<void> each(std::string_view sql, const std::function<void(const StoredRow&)>& take);
  /// All rows of a query.
  Expected<std::vector<StoredRow>> rows(std::string_view sql);

 private:
  explicit Store(std::unique_ptr<internal::SqliteConnection> connection);
  Expected<void> check_version();
  Expected<void> put_job(const JobOutcome& job);
  Expected<void> run(std::string_view sql, std::span<const StoredValue> values);
  Expected<internal::SqliteStatement*> statement(std::size_t i, const std::string& sql);

  std::unique_ptr<internal::SqliteConnection> connection_;
  std::vector<std::unique_ptr<internal::SqliteStatement>> statements_;
};

}  // namespace panelcal::batch
