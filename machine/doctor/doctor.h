// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/doctor/examination.h"
#include "machine/doctor/finding.h"

namespace panelcal {

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
/// See    tests/machine/doctor/doctor_test.cc
Findings examine(const Examination& examination);

}  // namespace panelcal
