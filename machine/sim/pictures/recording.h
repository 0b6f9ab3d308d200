// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/sim/sim_machine.h"
#include "program/walk/survey.h"
#include "program/walk/walk.h"
#include "vision/picture/files/folder.h"

namespace panelcal {

/// The result of a recording run.
struct Recording {
  Survey survey;
  std::vector<PictureRow> rows;  ///< as images.csv has them
};

/// Surveys a program on the virtual machine and keeps every picture: `NNNN.png`, numbered by seq
/// (`NNNN_2.png` and so on for further inspections, `NNNN_view2.png` for further views), and
/// images.csv with seq and tool.
///
/// x and y are where the optical axis stood according to the calibration: the commanded spindle
/// place plus the calibrated spindle-camera offset, since that is all a real machine could record.
/// With exact calibrations, and without a [table], it is where the axis really stood. What G39,SPOP
/// finds of the offset on the way is left out of it: a reader of the pictures finds it again.
///
/// Writes truth.json too, then images.csv (a folder that has it is complete), and at the end
/// synth.sha256 with the digest of every file: a later recording removes what is as it was written,
/// and nothing else. Whatever the survey finds fault with goes into the log; the pictures are kept
/// all the same.
///
/// In     folder: made if it does not exist
/// Fails  device-write; usage (the folder holds pictures that no recording wrote)
Expected<Recording> record_pictures(const Program& program,
                                    const MachineConfig& config,
                                    SimMachine& machine,
                                    const std::filesystem::path& folder,
                                    DiagnosticLog& log);

}  // namespace panelcal
