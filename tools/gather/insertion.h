// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/gather/database.h"

namespace panelcal::gather {

/// Inserts rows, many with one statement, since a server answers each over the network.
///
/// In     columns: "id, state, ..."; rows: all of one length
Expected<void> insert(Database& database,
                      std::string_view table,
                      std::string_view columns,
                      std::span<const StoredRow> rows);

}  // namespace panelcal::gather
