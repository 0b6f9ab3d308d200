// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/cli/options/facts_files.h"

namespace panelcal {

/// The commands of `panelcal calibrate`.
struct CalibrateOptions {
  std::string machine;
  std::string machine_driver;  ///< SOURCE: sim
  std::string camera;          ///< SOURCE: address of a live camera
  std::string output;          ///< the calibration's file; empty: none
  std::string clock;           ///< of the record, UTC: 2026-11-21T02:00:00Z; empty: now
  FactsFiles facts;
  bool install = false;
  /// Key of machine.toml whose file -o may name, since --install puts that in force; empty: none.
  std::string installed_key;
  // spindle-camera
  std::optional<int> spindle;  ///< absent: as [spindle] says
  std::optional<int> station;
  std::string reason;    ///< for the ledger
  std::string asked_by;  ///< empty: the user
  bool yes = false;      ///< no question about entry material
  bool force = false;    ///< install in spite of a significant trend
  // camera, table
  std::string images;              ///< SOURCE: a folder of pictures
  std::string form;                ///< CameraForm, or auto
  std::vector<double> at_mm;       ///< place of the mark
  std::optional<double> focal_px;  ///< absent: telecentric
  std::optional<double> zoom;
  int tool = 1;               ///< vision tool
  int per_side = 5;           ///< of the lattice of views
  std::string plate;          ///< the plate's file
  std::string measurements;   ///< looks at it
  std::string map;            ///< of the table's surface
  std::vector<double> range;  ///< of focus heights, mm, or of lamp levels; empty: see help
  int n_levels = 10;          ///< of the lamp
  double limit_um = 1;        ///< settle: an error that a picture may still see
  double longest_s = 1;       ///< settle: wait before the last picture of a move
  std::string linuxcnc;       ///< folder for what LinuxCNC understands; empty: none
  // camera-import, camera-export; focal_px too
  std::string exchange_file;              ///< another program's camera model, or a calibration
  std::string exchange_format;            ///< opencv, ros or mrcal
  std::optional<double> scale_mm_per_px;  ///< one of these two
  std::optional<double> distance_mm;      ///< of the panel from the lens
  double rotation_deg = 0;                ///< of the picture against the machine
  std::optional<double> corner_sigma_um;  ///< of a place in the picture's farthest corner
  double max_lens_error_px = 0.01;        ///< by which one model may miss the other
};

}  // namespace panelcal
