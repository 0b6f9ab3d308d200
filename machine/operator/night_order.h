// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "machine/operator/desk.h"
#include "machine/operator/screen.h"
#include "machine/operator/settings.h"

namespace panelcal::internal {

/// A night, or one kind of calibration, may be begun. It becomes the screen's running one.
///
/// Fails  usage (a job runs; recorded pictures; an unknown kind)
Expected<void> take_calibration(const StationSettings& settings,
                                const std::string& kind,
                                Screen& screen);

/// Calibrates as `panelcal nightly` does, in the calling thread; its lines, its verdict and its
/// page are on the desk. One kind is a night of that kind alone, measured whether or not this night
/// has measured it already.
///
/// Precondition: take_calibration()
void run_calibration(const StationSettings& settings,
                     const std::string& kind,
                     const std::string& who,
                     Desk& desk);

/// Puts an earlier calibration in force again, in the ledger and in its file.
///
/// In     kind: as the ledger writes it; to: an entry of that kind and of this machine
/// Fails  usage; config-value (no ledger); ledger-busy (a night runs); what the ledger reports
Expected<void> roll_back(const StationSettings& settings,
                         const std::string& kind,
                         std::int64_t to,
                         const std::string& reason,
                         const std::string& who);

/// The ledger of the machine, the newest entry first; empty where there is none, or none that can
/// be read.
std::vector<ScreenHistory> history_of(const StationSettings& settings);

}  // namespace panelcal::internal
