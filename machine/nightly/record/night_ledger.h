// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "machine/nightly/record/night_calibration.h"

namespace panelcal {

/// Opens the ledger of a night and checks all of it. A damaged one is kept aside and a new one
/// begun; that this was so is the first entry of the machine in the new one, and in `notes`.
///
/// Fails  what the ledger reports; device-write
/// See    tests/machine/nightly/nightly_test.cc
Expected<Ledger> open_night_ledger(const std::filesystem::path& file,
                                   const Clock& clock,
                                   const std::string& machine,
                                   const NightWords& words,
                                   std::vector<std::string>& notes);

}  // namespace panelcal
