// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/module.h"
#include "tools/modules/sqlite_functions.h"

namespace {

constexpr panelcal::modules::SqliteFunctions kSqliteFunctions = {
#define PANELCAL_VALUE(Result, name, parameters, arguments) .name = &sqlite3_##name,
    PANELCAL_SQLITE_FUNCTIONS(PANELCAL_VALUE)
#undef PANELCAL_VALUE
        .db_config = &sqlite3_db_config,
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kSqliteFunctions, nullptr};
