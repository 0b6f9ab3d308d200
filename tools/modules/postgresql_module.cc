// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/module.h"
#include "tools/modules/postgresql_functions.h"

namespace {

constexpr panelcal::modules::PostgresqlFunctions kPostgresqlFunctions = {
    .open_postgresql = &panelcal::gather::open_postgresql,
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kPostgresqlFunctions, nullptr};
