// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "calib/base/json/facts.h"
#include "calib/ledger/ledger.h"
#include "machine/nightly/record/noted_heads.h"
#include "tools/cli/provenance.h"
#include "tools/history/diff.h"
#include "tools/history/text.h"

// Parts of the document of facts "history" (share/schema/history.schema.json).
namespace panelcal::history {

/// The result of a command: for people, and as a part of the document.
struct AnswerPart {
  std::string text;
  facts::Json part;
  Provenance provenance = {};
};

/// An entry's content, its hash, and whether it is in force.
facts::Json entry_facts(const LedgerEntry& entry, bool in_force);

facts::Json changes_facts(std::span<const ParameterChange> changes);

/// The fate of a job, with a sample of its places for the arrows.
facts::Json job_shift_facts(const JobShift& shift, const JobShiftWords& words);

facts::Json verify_facts(const LedgerHead& head, const NotingFiles& held);

}  // namespace panelcal::history
