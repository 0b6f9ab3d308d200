// SPDX-License-Identifier: Apache-2.0
// SQLite itself, by way of a module that links it (see module.h): the ledger is opened late if at
// all, and its code knows nothing of modules.
#include <cstdarg>

#include "tools/modules/module.h"
#include "tools/modules/sqlite_functions.h"

namespace {

const panelcal::modules::SqliteFunctions& sqlite_functions() {
  static const auto& functions =
      panelcal::modules::load<panelcal::modules::SqliteFunctions>(panelcal::modules::kSqliteModule);
  return functions;
}

}  // namespace

extern "C" {

#define PANELCAL_FUNCTION(Result, name, parameters, arguments) \
  Result sqlite3_##name parameters {                           \
    return sqlite_functions().name arguments;                  \
  }
PANELCAL_SQLITE_FUNCTIONS(PANELCAL_FUNCTION)
#undef PANELCAL_FUNCTION

/// Only for the operations that take a number and a place for the answer.
int sqlite3_db_config(sqlite3* db, int operation, ...) {
  va_list arguments;
  va_start(arguments, operation);
  const int value = va_arg(arguments, int);
  int* const answer = va_arg(arguments, int*);
  va_end(arguments);
  return sqlite_functions().db_config(db, operation, value, answer);
}

}  // extern "C"
