// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "calib/base/diagnostic.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/correction/spindle_camera.h"
#include "calib/spindle/calibration_file.h"
#include "machine/config/settings/control_setting.h"
#include "machine/config/settings/coupon_options.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/settings/sim_options.h"
#include "machine/config/settings/stage_commands.h"
#include "machine/config/settings/vision_options.h"
#include "program/judge/job_check.h"
#include "program/walk/options.h"
#include "program/writers/gcode/setting.h"
#include "vision/fit/detection.h"
#include "vision/fit/target.h"
#include "vision/picture/picture_form.h"

namespace panelcal {

/// Date of a measurement, and its place in the machine's file.
struct OffsetDate {
  std::chrono::sys_seconds date;
  Place place;
  bool is_utc = false;  ///< false: by the clock on the wall
};

/// [spindle] calibration: where the offset comes from and goes to.
struct SpindleSetting {
  std::filesystem::path file;  ///< empty: [spindle] states the offset itself
  int spindle = 1;             ///< number of the machine's spindle that drills, 1 to 12
  int station = 1;             ///< 1 or 2
  /// False: the file is not there yet or does not have this spindle, so that camera_offset_mm only
  /// says where to begin a calibration.
  bool is_calibrated = true;
  /// camera_offset_mm, for any spindle that the file does not have.
  std::optional<Displacement<frame::Machine>> stated_offset;
  SpindleCalibration calibration;  ///< all that the file has
};

/// Of a machine that states nothing: a job is held against the default gates all the same.
inline WalkOptions default_walk_options() {
  WalkOptions walk;
  walk.base_limits = walk.nested_limits = default_gate_limits();
  return walk;
}

/// machine.toml as panelcal uses it. Unknown keys are errors that name the nearest known key.
struct MachineConfig {
  std::filesystem::path file;
  std::string name;
  std::optional<Travel> travel;
  ReadOptions reading;  ///< [program], [[diameter_page]]; without the program's own folder
  /// [vision] rotate, model, mode, cama, scale, default_tool; [gates]; [tolerance]; [program];
  /// [surface]; [reference_scaling]; [table]; [uncertainty], with [spindle], [camera] and [table],
  /// before any drift.
  /// The date and the program's name that texts name are not in it.
  WalkOptions walk = default_walk_options();
  LocateOptions locate;  ///< [vision] scores; centre and radius are set for each picture
  VisionOptions vision;  ///< [vision] search and four views; [camera] focus, lamp
  std::map<int, Target> vision_tools;         ///< [[vision.tool]]
  std::optional<CameraCalibration> camera;    ///< [camera] calibration, read from its own file
  std::filesystem::path camera_file;          ///< of `camera`; empty without
  Time camera_patience = seconds(5);          ///< [camera] patience_s
  std::map<double, CameraCalibration> zooms;  ///< [[camera.zoom]], by level
  std::map<double, std::filesystem::path> zoom_files;  ///< of `zooms`
  std::filesystem::path table_file;  ///< [table] calibration, of `walk.table`; or empty
  std::optional<std::chrono::sys_seconds> table_date;  ///< of that calibration
  PictureForm picture_form;                            ///< [camera] bayer, bits
  SpindleCameraOffset spindle_camera;  ///< [spindle], or of the calibration that it names
  SpindleSetting spindle_setting;
  /// Date of the offset's calibration: [spindle] camera_offset_date, or what the calibration says.
  std::optional<OffsetDate> offset_date;
  std::optional<Coupon> coupon;          ///< [coupon]
  std::filesystem::path ledger_file;     ///< [ledger] file; empty without
  std::optional<NightlyConfig> nightly;  ///< [nightly]
  double drift_um_per_sqrt_day = 0;      ///< [uncertainty]: random walk of the offset, per axis
  StageCommands stage;                   ///< [machine] stage_command and its kin, for --camera
  ControlSetting control;                ///< [machine] driver and its kin, in place of `stage`
  Time settle;                           ///< [machine] settle_s: from an arrival to a picture
  std::optional<GcodeSetting> gcode;     ///< [gcode], for `run --to gcode`
  std::optional<SimConfig> sim;          ///< [sim]

  /// There is something that drives the stage, by command or by a control.
  bool can_move() const { return control.driver.has_value() || !stage.move.empty(); }
  bool can_probe() const { return control.probe.has_value() || !stage.probe.empty(); }
};

}  // namespace panelcal
