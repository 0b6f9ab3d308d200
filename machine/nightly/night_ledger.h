// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panelcal/calib/base/clock.h"
#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/ledger.h"
#include "panelcal/machine/nightly/night_calibration.h"

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
