// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "tools/history/certificate/certificate.h"

namespace panelcal::history {

/// Members of the document of facts "certificate" (share/schema/certificate.schema.json).
facts::Json certificate_facts(const Certificate& certificate);

/// For the terminal.
///
/// In     verified: the line of what the ledger was held against
std::string certificate_text(const Certificate& certificate, const std::string& verified);

}  // namespace panelcal::history
