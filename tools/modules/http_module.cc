// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/http_functions.h"
#include "tools/modules/module.h"

namespace {

constexpr panelcal::modules::HttpFunctions kHttpFunctions = {
    .open_tls_identity = &panelcal::serve::open_tls_identity,
    .serve_connection = &panelcal::serve::serve_connection,
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kHttpFunctions, nullptr};
