// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/controls/control.h"

namespace panelcal {

/// A machine behind GRBL 1.1, grblHAL or FluidNC.
///
/// Moves are jogs in machine coordinates (`$J=G53 ...`): work zeros, G92 and tool lengths do not
/// change them, nor do they change the modes of the control. A move has arrived when the control
/// is idle and reports the place it was sent to, whose steps are read back. The control is never
/// unlocked ($X), and homed only where [machine] homing says so.
///
/// A probing move (G38.2) is relative, so that no offset counts, and its answer [PRB:...] is in
/// machine coordinates; the modes that it changes are set back.
///
/// After a failure the machine is stopped: a jog is cancelled (0x85), another move is held (!) and
/// then reset (0x18). The diagnostic says whether it stands, and where. Nothing moves any more
/// until the control is opened anew.
///
/// Fails  device-stage (see Talk; a state in which it must not be moved); interrupted;
/// not-supported Source GRBL 1.1 interface and jogging pages; grblHAL for H: and Pn:O See
/// tests/machine/devices/controls/grbl/grbl_test.cc
Expected<OpenedControl> open_grbl(const MachineConfig& config);

}  // namespace panelcal
