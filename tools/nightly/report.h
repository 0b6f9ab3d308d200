// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "machine/nightly/record/night_record.h"
#include "tools/cli/provenance.h"

// Reports of `panelcal nightly` on a night: five lines, and its facts.
namespace panelcal::nightly {

/// A few lines for people who read mail: the verdict, what became of each calibration, what changed
/// since last week, the self-test, what is strange. Of nothing to say there is no line.
std::string night_text(const NightRecord& record);

/// All of a night (docs/formats/nightly.md, share/schema/night.schema.json), which its page shows.
///
/// See    tests/tools/nightly/facts_test.cc
facts::Json night_facts(const NightRecord& record, const Provenance& provenance);

}  // namespace panelcal::nightly
