// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "machine/config/settings/control_setting.h"

#include "tests/machine/devices/controls/linuxcnc/fake_linuxcnc.h"

namespace panelcal::test {

/// A machine file's part for a fake at a port: safe Z 0, probing from -10 to -20 at Z0 -12.
ControlSetting control_of_fake(int port);

/// What came of a job of two moves and a touch, with one fault in it.
struct FaultedJob {
  int n_requests = 0;
  std::string text;  ///< of the diagnostic; empty: the job came to its end
  bool moves_on = false;
  bool was_low = false;  ///< X or Y moved with Z low
};

/// In     at: the number of the request, from 0; in_move: or of a move, from 1, of which the fifth
///        probes
FaultedJob run_with_fault(CncFault fault, int at, int in_move = 0);

/// A word that the diagnostic of a fault has to hold.
std::string_view cause_of(CncFault fault);

}  // namespace panelcal::test
