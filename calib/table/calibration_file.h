// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/correction/table_map.h"
#include "calib/table/fit.h"

namespace panelcal {

/// The calibration of a table with all that makes it a record: when, from what, how well.
///
/// The covariance of the map's coefficients is left out: of an ordinary grid it is a hundred times
/// the rest of the file. `sigma` stands for it.
struct TableCalibration {
  TableMap map;
  TableGeometry geometry;
  /// In words, as TableFit has it; the map has none of these errors.
  std::vector<std::string> undetermined;
  Length sigma;                        ///< of the map's error per axis, rms over its rectangle
  Length rms;                          ///< of the residuals' lengths
  std::optional<Length> held_out_rms;  ///< of looks that the fit did not see
  std::chrono::sys_seconds date{};
  std::string provenance;  ///< its origin, in the words of its maker
};

/// The calibration that holds a fitted table; date and provenance are left to the caller.
TableCalibration calibration_of(const TableFit& fit);

inline constexpr std::size_t kMaxTableCalibrationBytes = std::size_t{1} << 24;

/// Reads `*.cal.json` of kind "table", version 1.
///
/// Strict, as read_camera_calibration is: unknown and missing keys, wrong types, a grid that is
/// none, errors of more than 100 mm, a map that is not one to one and a covariance that is not
/// positive semidefinite are refused.
///
/// Fails  file-unreadable; json-syntax (with line and column); calibration-invalid
/// See    docs/formats/calibration.md; tests/calib/table/calibration_file_test.cc
Expected<TableCalibration> read_table_calibration(const std::filesystem::path& path);

/// The same from text; `file` is what diagnostics name. Any bytes give a value or a diagnostic.
Expected<TableCalibration> parse_table_calibration(std::string_view text, const std::string& file);

/// The file's content; numbers in the fewest digits that read back exactly.
std::string table_calibration_text(const TableCalibration& calibration);

/// Writes the file whole or not at all; refuses what the reader would refuse.
///
/// Fails  calibration-invalid; device-write
Expected<void> write_table_calibration(const std::filesystem::path& path,
                                       const TableCalibration& calibration);

}  // namespace panelcal
