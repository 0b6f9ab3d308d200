// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/drift/night_gates.h"
#include "calib/ledger/ledger.h"
#include "calib/spindle/calibration_file.h"
#include "machine/calibrate/calibration.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"

namespace panelcal {

/// "spindle 1 station 1", as the ledger's subject.
std::string subject(SpindleAt at);

/// The ledger's key of the offset that [spindle] names. A machine without a name is "machine".
LedgerKey spindle_camera_key(const MachineConfig& config);

/// The run's offset for the ledger: parameters offset_x and offset_y in mm with their covariance;
/// the file of this one spindle as the result, in whose "quality" is the rest; machine.toml and the
/// camera's calibration, which the offset goes with, as inputs.
///
/// In     inputs: as spindle_camera_inputs() had them before the run
/// Fails  calibration-invalid (a fit that makes no file)
Expected<LedgerDraft> spindle_camera_draft(const MachineConfig& config,
                                           const SpindleCameraRun& run,
                                           const RecordWords& words,
                                           std::vector<LedgerInput> inputs);
/// To be asked before rows of the coupon are used up: a file that is gone later takes no offset
/// away, and one that has changed meanwhile is not what the run was made with.
///
/// Fails  file-unreadable
Expected<std::vector<LedgerInput>> spindle_camera_inputs(const MachineConfig& config);

/// The run's offset, as gates are held against it.
NightResult spindle_camera_result(const SpindleCameraRun& run);

/// Spindles of which [spindle] calibration's file has an offset past the ledger: another one than
/// what is in force, and none that was installed before. An operator put it there by hand
/// (`calibrate -o`), and to write the file again would lose it. None where the file is not there or
/// is damaged, and none of the time before the first installation.
Expected<std::vector<SpindleAt>> spindles_by_hand(const MachineConfig& config,
                                                  const Ledger& ledger);

/// The offset of [spindle] on the next free rows of [coupon].
///
/// With one spindle the file is its entry's result, byte for byte; with several the offsets of all
/// that are in force are put together, in their order. Spindles that only the file has are kept.
///
/// See    tests/machine/calibrate/kinds/spindle_camera_test.cc
std::unique_ptr<Calibration> spindle_camera_kind(std::shared_ptr<MachineConfig> config);

}  // namespace panelcal
