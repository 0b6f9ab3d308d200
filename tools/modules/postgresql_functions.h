// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/gather/database.h"

namespace panelcal::modules {

inline constexpr const char* kPostgresqlModule = "libpanelcal_postgresql.so";

/// PostgreSQL. libpq, with Kerberos, LDAP and OpenSSL.
struct PostgresqlFunctions {
  decltype(&panelcal::gather::open_postgresql) open_postgresql;
};

}  // namespace panelcal::modules
