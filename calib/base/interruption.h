// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/base/units.h"

namespace panelcal {

/// From here on SIGINT, SIGTERM and SIGHUP only ask this process to end: the program that moves
/// something is halted first, and files and devices are closed. A second signal of the kind ends it
/// at once.
void heed_interruptions();

/// The number of the signal that asked to end; 0 while none did.
int interruption();

/// Readable from the first such signal on, for poll(); -1 where signals are not heeded.
int interruption_fd();

/// Fails  interrupted: a signal asked to end
Expected<void> check_interruption();

/// Sleeps, but not beyond an interruption.
void sleep_for(Time time);

}  // namespace panelcal
