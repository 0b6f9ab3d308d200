// SPDX-License-Identifier: Apache-2.0
// PostgreSQL, by way of its module (see module.h).
#include "tools/modules/module.h"
#include "tools/modules/postgresql_functions.h"

namespace panelcal::gather {

Expected<std::unique_ptr<Database>> open_postgresql(const std::string& address) {
  static const auto& functions =
      modules::load<modules::PostgresqlFunctions>(modules::kPostgresqlModule);
  return functions.open_postgresql(address);
}

}  // namespace panelcal::gather
