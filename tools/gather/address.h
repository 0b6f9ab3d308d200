// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal::gather {

/// True for "postgresql://..." and "postgres://...".
bool is_postgresql(std::string_view address);

/// A word of a command line without the password of the PostgreSQL address that it has, for
/// messages and files. Other text stays as it is.
std::string without_database_password(std::string_view word);

}  // namespace panelcal::gather
