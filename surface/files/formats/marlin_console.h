// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "surface/files/grid_reader.h"
#include "surface/files/text_fields.h"
#include <Eigen/Core>

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// A mesh as Marlin prints it, rows from low y.
struct MarlinTable {
  TextField title;
  int n_columns = 0;
  std::vector<std::vector<ReadNode>> rows;
  /// Of the report of unified bed leveling: whole mm, cut off towards 0.
  std::optional<Eigen::Vector2d> low_mm, high_mm;
};

/// `Bed X: 50.000 Y: 60.000 Z: -0.013`: one touch of the bed.
struct MarlinTouch {
  Eigen::Vector2d place_mm;
  double height_mm = 0;
  TextField from;
};

/// Meshes and touches of a console.
struct MarlinRecords {
  std::vector<MarlinTable> tables;
  std::vector<MarlinTouch> touches;
  std::vector<double> x_mm, y_mm;  ///< `X-Axis Mesh Points at:`, of `G29 W`; empty: not stated
};

/// Reads the lines of a console, whatever stands ahead of each: `Recv: `, or a time of day.
///
/// Fails  measurement-file: a table that is cut off or damaged
/// Source Marlin, print_2d_array(), unified_bed_leveling::display_map() and g29_what_command()
///        of 1.1 and 2.x
Expected<MarlinRecords> read_marlin_records(std::string_view text, const std::string& file);

}  // namespace panelcal::internal
