// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/ledger/ledger.h"
#include "machine/nightly/record/night_record.h"

namespace panelcal {

/// Puts into a record what its checks and steps come to: the outcome, whether holes may be drilled
/// and until when, and the sentence that says so.
void fill_verdict(NightRecord& record);

/// The same, recorded: what is found again without the report.
///
/// In     key: machine and asked_by, software, temperature of the record
LedgerDraft night_draft(const NightRecord& record, const std::string& machine);

}  // namespace panelcal
