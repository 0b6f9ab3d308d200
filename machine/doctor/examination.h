// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "calib/base/clock.h"
#include "machine/doctor/finding.h"

namespace panelcal {

/// What is examined, and how far.
struct Examination {
  std::filesystem::path machine_toml;
  std::string camera;  ///< its address; empty: that of [nightly]
  /// Opens the camera and the control too. Opening a control may end what another program does with
  /// it: GRBL's serial device resets it, and linuxcncrsh gives the control to the newest client.
  bool opens_devices = false;
  Clock clock;
  std::string software;  ///< "panelcal 0.1.0"
  std::string asked_by;
};

/// Looks at a machine.toml and at everything that it names: whether jobs can be done now and the
/// night tonight, what is stale, what is assumed.
///
///   machine.toml   is read with all that it names, and held against itself (check_machine)
///   assumed        lines that panelcal init has marked so
///   calibrations   their dates, and whether anything was measured
///   tolerance      the smallest sigma that any hole can have, against [tolerance]
///   programs       of commands: can be executed
///   files          ledger whole and writable, reports' folder writable, room on the disk
///   devices        the camera takes a picture of the calibrated size; the control may be moved
///   tonight        a dry run of the night
///
/// Nothing moves and nothing is written.
///
/// See    tests/machine/doctor/examination_test.cc
Findings examine(const Examination& examination);

}  // namespace panelcal
