// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include <sys/types.h>

namespace panelcal {

/// From here on SIGINT, SIGTERM and SIGHUP only ask this process to end: the program that moves
/// something is halted first, and files and devices are closed. A signal half a second later or
/// more ends (SIGKILL) the programs that are still being halted, whereupon this process ends as
/// after the first; without such programs it ends this process at once. SIGQUIT ends both at once.
void heed_interruptions();

/// The number of the signal that asked to end; 0 while none did.
int interruption();

/// Readable from the first such signal on, for poll(); -1 where signals are not heeded.
int interruption_fd();

/// Names the process group of a running program to the signals, as long as it exists.
class HaltedGroup {
 public:
  explicit HaltedGroup(pid_t group);
  HaltedGroup(const HaltedGroup&) = delete;
  HaltedGroup& operator=(const HaltedGroup&) = delete;
  ~HaltedGroup();

 private:
  pid_t group_;
};

/// Fails  interrupted: a signal asked to end
Expected<void> check_interruption();

/// Sleeps, but not beyond an interruption.
void sleep_for(Time time);

}  // namespace panelcal
