// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sqlite3.h>

namespace panelcal::modules {

inline constexpr const char* kSqliteModule = "libpanelcal_sqlite.so";

/// The functions of SQLite that calib/ledger/database/sqlite.cc calls, with their parameters.
#define PANELCAL_SQLITE_FUNCTIONS(X)                                                         \
  X(int, bind_double, (sqlite3_stmt * s, int i, double v), (s, i, v))                        \
  X(int, bind_null, (sqlite3_stmt * s, int i), (s, i))                                       \
  X(int, bind_int64, (sqlite3_stmt * s, int i, sqlite3_int64 v), (s, i, v))                  \
  X(int, busy_timeout, (sqlite3 * db, int ms), (db, ms))                                     \
  X(int, close, (sqlite3 * db), (db))                                                        \
  X(const void*, column_blob, (sqlite3_stmt * s, int i), (s, i))                             \
  X(int, column_count, (sqlite3_stmt * s), (s))                                              \
  X(double, column_double, (sqlite3_stmt * s, int i), (s, i))                                \
  X(int, column_bytes, (sqlite3_stmt * s, int i), (s, i))                                    \
  X(sqlite3_int64, column_int64, (sqlite3_stmt * s, int i), (s, i))                          \
  X(int, column_type, (sqlite3_stmt * s, int i), (s, i))                                     \
  X(sqlite3*, db_handle, (sqlite3_stmt * s), (s))                                            \
  X(int, db_readonly, (sqlite3 * db, const char* name), (db, name))                          \
  X(const char*, errmsg, (sqlite3 * db), (db))                                               \
  X(int, extended_errcode, (sqlite3 * db), (db))                                             \
  X(int, extended_result_codes, (sqlite3 * db, int on), (db, on))                            \
  X(int, file_control, (sqlite3 * db, const char* name, int op, void* p), (db, name, op, p)) \
  X(int, finalize, (sqlite3_stmt * s), (s))                                                  \
  X(int, get_autocommit, (sqlite3 * db), (db))                                               \
  X(int, reset, (sqlite3_stmt * s), (s))                                                     \
  X(int, step, (sqlite3_stmt * s), (s))                                                      \
  X(int, system_errno, (sqlite3 * db), (db))                                                 \
  X(int,                                                                                     \
    bind_text64,                                                                             \
    (sqlite3_stmt * s,                                                                       \
     int i,                                                                                  \
     const char* text,                                                                       \
     sqlite3_uint64 n,                                                                       \
     void (*destroy)(void*),                                                                 \
     unsigned char encoding),                                                                \
    (s, i, text, n, destroy, encoding))                                                      \
  X(int,                                                                                     \
    exec,                                                                                    \
    (sqlite3 * db,                                                                           \
     const char* sql,                                                                        \
     int (*row)(void*, int, char**, char**),                                                 \
     void* user,                                                                             \
     char** error),                                                                          \
    (db, sql, row, user, error))                                                             \
  X(int,                                                                                     \
    open_v2,                                                                                 \
    (const char* file, sqlite3** db, int flags, const char* vfs),                            \
    (file, db, flags, vfs))                                                                  \
  X(int,                                                                                     \
    prepare_v2,                                                                              \
    (sqlite3 * db, const char* sql, int n, sqlite3_stmt** s, const char** tail),             \
    (db, sql, n, s, tail))

struct SqliteFunctions {
#define PANELCAL_FIELD(Result, name, parameters, arguments) decltype(&sqlite3_##name) name;
  PANELCAL_SQLITE_FUNCTIONS(PANELCAL_FIELD)
#undef PANELCAL_FIELD
  decltype(&sqlite3_db_config) db_config;
};

}  // namespace panelcal::modules
