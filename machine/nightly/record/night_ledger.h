// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "machine/nightly/record/night_files.h"

namespace panelcal {

/// Opens the ledger of a night, checks all of it, and holds it against the files that note its head
/// (check_noted_heads). A damaged one is kept aside and a new one
/// begun; that this was so is the first entry of the machine in the new one, and in `notes`.
///
/// Fails  ledger-cut-off; what the ledger reports; device-write
/// See    tests/machine/nightly/nightly_test.cc
Expected<Ledger> open_night_ledger(const NightFiles& files,
                                   const Clock& clock,
                                   const std::string& machine,
                                   const RecordWords& words,
                                   std::vector<std::string>& notes);

}  // namespace panelcal
