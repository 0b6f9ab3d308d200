// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "tools/batch/store/store.h"
#include "tools/gather/database.h"

namespace panelcal::gather {

/// The name of a batch in every database: of its manifest, its options, its time and the version
/// that began it, so that the same batch is the same wherever its results lie.
std::string batch_id(const batch::StoredBatch& batch);

/// Brings the jobs of a batch's own store into a database.
///
/// Every job has the SHA-256 of its rows there. One that is missing or has another is put in, whole
/// and in the place of what was there; what the database has already is not sent again. So a
/// delivery that was cut off anywhere is finished by another one, and a second one changes nothing.
///
/// Fails  as Database; what the store reports
/// See    docs/decisions/gathering.md; tests/tools/gather_test.py
class JobDelivery {
 public:
  /// Names the batch in the database.
  static Expected<JobDelivery> begin(const std::string& address, batch::Store& store);

  /// Jobs by their numbers, as far as the store has them.
  ///
  /// Out    the number of those that were put in
  Expected<std::int64_t> deliver(std::span<const std::int64_t> numbers);
  Expected<std::int64_t> deliver_all();

  const std::string& database_name() const { return database_->name(); }

 private:
  JobDelivery(std::unique_ptr<Database> database, batch::Store& store, std::string id);
  Expected<std::int64_t> deliver_some(std::span<const std::int64_t> numbers);

  std::unique_ptr<Database> database_;
  batch::Store* store_;
  std::string id_;
};

}  // namespace panelcal::gather
