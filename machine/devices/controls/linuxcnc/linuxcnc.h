// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/controls/control.h"

namespace panelcal::internal {

/// LinuxCNC through its linuxcncrsh, by MDI lines.
///
/// Moves go by G53 to places of the machine, so that G54..G59.3, their rotation, G92 and tool
/// offsets do not matter to them; what does (cutter compensation, lathe diameters) is refused.
/// Probing is one relative move of Z (G91 G38.3), which none of them turns or shifts; the place of
/// the touch is #5063, as the distance from where Z stands, and never where Z has stopped. The
/// operator's unit is used as it is; distance mode, feed mode and feed come back afterwards.
///
/// An operator's stop, hold, error, lost connection or signal ends a move: the control is told to
/// abort, over a new connection if need be, and the diagnostic says whether the machine stands.
///
/// Fails  device-stage (see open_control; not homed, emergency stop, switched off, busy, axis at a
///        limit); interrupted
/// Source linuxcncrsh(1); LinuxCNC's G-code manual, G38.n, G53, predefined parameters
/// See    tests/machine/devices/controls/linuxcnc/, tests/machine/linuxcnc_test.py
Expected<OpenedControl> open_linuxcnc(const MachineConfig& config);

}  // namespace panelcal::internal
