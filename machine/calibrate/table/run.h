// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/ledger/ledger.h"
#include "calib/table/calibration_file.h"
#include "calib/table/fit.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/config/machine_config.h"
#include "machine/config/plate/plate.h"
#include "machine/look/mark_sights.h"

namespace panelcal {

/// Looks at a plate, ready for the fit, and where they came from.
struct TableSights {
  TableData data;
  std::vector<LedgerInput> inputs;
  std::vector<MissedPicture> left_out;   ///< pictures that were not looked at
  std::vector<std::string> without_tag;  ///< pictures, as in MarkSights
};

inline constexpr std::size_t kMaxPlateLookBytes = std::size_t{1} << 28;

/// Reads looks at a plate that any vision system has measured, JSON Lines:
///
///   {"pose":0,"axis":[120.5,80.25],"dot":[3,7],"seen":[0.0123,-0.0045],"cov":[1e-6,0,1e-6]}
///
/// pose: which way the plate lay, from 0; axis: where the optical axis was sent to (as in
/// images.csv); dot: column and row; seen: from the axis to the dot, machine directions, mm; cov:
/// xx, xy, yy of that in mm^2, of the picture alone. Lines of one pose and axis are one view.
/// Blank lines are allowed.
///
/// The map is one of where the stage stands, so to each axis the spindle-camera offset is taken
/// back; to each covariance comes [uncertainty] stage_repeatability_um.
/// Fails  json-syntax; measurement-file; measurement-invalid (no covariance); calibration-data (a
///        dot that the plate does not have, or in whose place a tag is)
/// See    tests/machine/calibrate/table/run_test.cc
Expected<TableSights> parse_plate_looks(std::string_view text,
                                        const std::string& file,
                                        const MachineConfig& config,
                                        const CalibrationPlate& plate);
Expected<TableSights> read_plate_looks(const std::filesystem::path& file,
                                       const MachineConfig& config,
                                       const CalibrationPlate& plate);

/// A calibrated table, and from what. Nothing is installed.
struct TableRun {
  TableSights sights;
  TableFit fit;
  TableCalibration calibration;  ///< without date and provenance
  /// By how much the looks scatter more than they say; 1 where they do not. All sigmas of the
  /// result have been multiplied by it.
  double excess = 1;
  /// Looks that do not fit the others and are not in `sights` any more: which, and by how much.
  std::vector<std::string> left_out;
};

/// Fits the table to looks at a plate; without those that do not fit the others, and with sigmas
/// multiplied by what looks scatter more than stated.
///
/// Fails  calibration-data; calibration-invalid (a map that no reader would accept)
Expected<TableRun> calibrate_table(const MachineConfig& config,
                                   TableSights sights,
                                   const TableFitOptions& options = {});

/// The reason not to use this map without a look at it; empty if nothing speaks against it.
/// Limits are on looks left out, on the held-out check in um, and on the excess.
std::string refusal(const TableRun& run);

/// In lines, as a machine builder reads them: scale in ppm, squareness in urad, straightness and
/// linearity in um, each with its sigma; what is undetermined; residuals and held-out check.
std::string report(const TableRun& run);

LedgerKey table_key(const MachineConfig& config);

/// For the ledger: the geometry with its covariance, the file as the result, machine.toml and what
/// was looked at as inputs.
///
/// Fails  file-unreadable (machine.toml is gone)
Expected<LedgerDraft> table_draft(const MachineConfig& config,
                                  const TableRun& run,
                                  const RecordWords& words);

}  // namespace panelcal
