// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <utility>

#include "calib/ledger/database/sqlite.h"
#include "tools/batch/store/outcome.h"

// Values of rows on their way to SQLite and back, and its problems in the words of a store.
namespace panelcal::batch {

/// Binds a value; a number that is not finite becomes NULL.
void bind(internal::SqliteStatement& statement, int i, const StoredValue& value);

/// The row at which a statement stands.
StoredRow row_of(const internal::SqliteStatement& statement);

/// A problem of a connection, which speaks of a ledger.
///
/// In     whole: the expected file, such as "the store of a batch, whole"
Diagnostic of_database(Diagnostic problem, std::string_view whole);

template <class T>
Expected<T> of_database(Expected<T> value, std::string_view whole) {
  if (!value) return failure(of_database(std::move(value).error(), whole));
  return value;
}

}  // namespace panelcal::batch
