// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"

namespace panelcal::history {

/// One parameter over time as an SVG: each point with a bar of one standard deviation to either
/// side; what was installed is filled, what was refused is a cross, what was only measured hollow.
///
/// Fails  ledger-entry-unknown (there are no points to show); names the file of `file`
Expected<std::string> series_svg(const LedgerSeries& series,
                                 const LedgerKey& key,
                                 const std::string& parameter,
                                 const std::string& file);

}  // namespace panelcal::history
