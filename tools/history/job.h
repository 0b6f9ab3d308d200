// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "tools/cli/commands.h"
#include "tools/history/diff.h"
#include "tools/history/facts.h"

namespace panelcal::history {

/// The output of `history diff --program` on top of the parameters. Warnings about the program go
/// to the console.
///
/// Fails  usage; what the machine file, the program and its measurements report; as job_shift
Expected<AnswerPart> job_answer(const HistoryOptions& options,
                                CommandContext& context,
                                const CalibrationEntry& before,
                                const CalibrationEntry& after);

}  // namespace panelcal::history
