// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "tools/cli/commands.h"
#include "tools/history/diff.h"

namespace panelcal::history {

/// The output of `history diff --program` on top of the parameters: text, or a JSON object.
/// Writes the picture if one is asked for. Warnings about the program go to the console.
///
/// Fails  usage; what the machine file, the program and its measurements report; as job_shift
Expected<std::string> job_answer(const HistoryOptions& options,
                                 CommandContext& context,
                                 const CalibrationEntry& before,
                                 const CalibrationEntry& after);

}  // namespace panelcal::history
