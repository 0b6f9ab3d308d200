// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "tools/cli/commands.h"
#include "tools/history/facts.h"

namespace panelcal::history {

/// Checks every hash of a ledger, and holds it against the files that note its head: those of
/// --against, and those that machine.toml names (calibrations, the folder of reports). The chain
/// alone does not tell that its newest entries were deleted.
///
/// Fails  ledger-corrupt; ledger-cut-off; file-unreadable (a file of --against); output-in-use;
///        toml-syntax
/// See    tests/tools/noted_heads_test.py
Expected<AnswerPart> verify_answer(const HistoryOptions& options,
                                   CommandContext& context,
                                   const Ledger& ledger);

}  // namespace panelcal::history
