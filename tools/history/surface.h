// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "tools/history/diff.h"

namespace panelcal::history {

/// The `surface diff` of the maps of two entries: text, or one JSON object with its line end.
///
/// In     file: the ledger's, for messages
/// Fails  as parse_map_file() and difference_of()
Expected<std::string> surface_answer(const CalibrationEntry& before,
                                     const CalibrationEntry& after,
                                     const std::string& file,
                                     bool as_json);

}  // namespace panelcal::history
