// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "tools/history/diff.h"
#include "tools/history/facts.h"

namespace panelcal::history {

/// The `surface diff` of the maps of two entries.
///
/// In     file: the ledger's, for messages
/// Fails  as parse_map_file() and difference_of()
Expected<AnswerPart> surface_answer(const CalibrationEntry& before,
                                    const CalibrationEntry& after,
                                    const std::string& file);

}  // namespace panelcal::history
