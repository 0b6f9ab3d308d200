// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/drift/model.h"
#include "calib/drift/monitor.h"
#include "calib/drift/night_gates.h"
#include <Eigen/Core>

namespace panelcal {

/// The trials of nights at the mark, and their tolerances.
struct NightTrials {
  /// [nightly.focus] tolerance_um: so far from the best height the camera still sees well enough.
  Length focus_tolerance = um(100);
  /// [nightly.light]: the levels that are tried. Less than a step between them does not matter.
  double lamp_low = 10;
  double lamp_high = 100;
  int n_lamp_levels = 10;
  /// [nightly.settle]: an error that a picture may still see, the longest wait that is tried, and
  /// what of a wait does not matter.
  Length settle_limit = um(1);
  Time settle_longest = seconds(1);
  Time settle_tolerance = seconds(0.05);

  double lamp_step() const { return (lamp_high - lamp_low) / (n_lamp_levels - 1); }
};

/// [nightly.table]: what "table" calibrates on, and where to.
struct NightTable {
  std::filesystem::path plate;  ///< fixed to the machine; empty without the table
  std::filesystem::path file;   ///< of the calibration; empty: that of [table]
};

/// [nightly.surface]: where "surface" probes the table, and what its map is held to.
struct NightSurface {
  std::filesystem::path file;                        ///< of the map; empty without the surface
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();  ///< corners of the probed rectangle, machine
  Eigen::Vector2d high_mm = Eigen::Vector2d::Zero();
  int n_columns = 0;  ///< of places, the outermost on the rectangle's sides
  int n_rows = 0;
  int n_repeats = 2;           ///< readings at each place
  Length height;               ///< where the surface is expected, above Z0
  Length probe_sigma = um(3);  ///< of a reading that does not say it
  Length sigma = um(10);       ///< largest one of the map within the rectangle
  /// Largest changes against the map in force: of the middle's height; of an edge's against the
  /// middle by tilt, and by bow or twist; at any place that is probed.
  Length offset = um(50);
  Length tilt = um(50);
  Length bow = um(50);
  Length anywhere = um(50);
  Place place;  ///< of high_mm, for messages
};

/// [nightly] of a machine.toml: what is calibrated at night, and what it is held to.
struct NightlyConfig {
  /// "focus", "light", "settle", "camera", "spindle-camera", "table", "surface"; in this order,
  /// since an offset goes with its camera, and looks at a plate with both.
  std::vector<std::string> calibrate = {"spindle-camera"};
  /// machine_driver = "sim": the virtual machine of [sim]. Otherwise `camera` is a camera's
  /// address.
  bool is_simulated = false;
  std::string camera;
  /// How long the stage moves to and fro before anything is measured; with a limit, at most.
  Time warm_up;
  /// The mark is looked at meanwhile, until the rest of its way is below this.
  std::optional<Length> warm_up_limit;
  /// A mark fixed to the table, which the self-test looks at; absent: there is none.
  std::optional<Position<frame::Machine>> mark;
  Place mark_place;                        ///< of mark_mm, for messages
  int mark_tool = 1;                       ///< the vision tool that finds it
  std::filesystem::path reports;           ///< folder; empty: none are wanted
  std::filesystem::path temperature_file;  ///< a number in degrees Celsius; empty without
  /// A program that prints it, and its words; empty without.
  std::vector<std::string> temperature_command;
  double min_disk_mb = 100;  ///< free where the ledger lies; with less nothing is begun
  /// The hour of UTC at which a night ends and the next begins: noon where the machine stands.
  int noon_utc_h = 12;
  NightLimits limits;    ///< [nightly.gates], and the forecast's of [nightly.drift]
  DriftOptions drift;    ///< [nightly.drift]
  WatchOptions watch;    ///< [nightly.drift]
  NightTrials trials;    ///< [nightly.focus], [nightly.light], [nightly.settle]
  NightTable table;      ///< [nightly.table]
  NightSurface surface;  ///< [nightly.surface]
  Place place;           ///< of [nightly], for messages
};

}  // namespace panelcal
