// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/camera/calibration_file.h"
#include "calib/camera/mapping.h"
#include "calib/correction/spindle_camera.h"
#include "calib/correction/spindle_offsets.h"
#include "calib/panel/gates.h"
#include "calib/spindle/calibration_file.h"
#include "machine/calibrate/coupon.h"
#include "machine/config/vision_options.h"
#include "machine/devices/command_stage.h"
#include "machine/nightly/night_config.h"
#include "machine/sim/sim_coupon_options.h"
#include "machine/sim/sim_table.h"
#include "machine/sim/sim_table_surface.h"
#include "machine/sim/simulated_probe.h"
#include "program/judge/job_check.h"
#include "program/walk/walk.h"
#include "program/writers/gcode_setting.h"
#include "vision/fit/target.h"
#include "vision/locate/locate.h"
#include "vision/picture/bayer.h"
#include "vision/render/scene_debris.h"

namespace panelcal {

/// [sim]: the hidden truth of the virtual machine. Only machine/sim and `synth` read it.
struct SimConfig {
  std::uint64_t seed = 1;
  // The panel: actual = R(rotation) diag(1 + stretch) nominal + offset, about work zero.
  Displacement<frame::Actual> panel_offset;
  Angle panel_rotation;
  double stretch_x_ppm = 0;
  double stretch_y_ppm = 0;
  // Every step-and-repeat instance on top of it: normal scatter of one standard deviation per axis,
  // the rotation about the instance's own first target.
  Length board_offset_sigma;
  Angle board_rotation_sigma;
  /// The real camera, of which [camera] is the calibration. Absent: the calibration is exact.
  std::optional<CameraMapping::Parameters> camera;
  /// The real offset; absent: as calibrated.
  std::optional<Displacement<frame::Machine>> spindle_camera_offset;
  int width_px = 640;  ///< as [camera] was calibrated for, if there is one
  int height_px = 480;
  double blur_px = 1.0;         ///< sigma of the lens, 0.3 or more
  double noise = 0;             ///< sigma in grey levels of 255
  double background = 0.3;      ///< 0 to 1 of full scale
  double target_level = 0.7;    ///< of bright targets; dark ones are as much darker, down to black
  double light_gradient = 0;    ///< relative change from the left to the right edge of the picture
  double light_gradient_y = 0;  ///< from top to bottom
  double vignetting = 0;        ///< relative loss of light in the corners
  double weave_amplitude = 0;   ///< of full scale
  Length weave_period = mm(0.5);
  int neighbors = 0;        ///< other pads in each view
  double full_scale = 255;  ///< or 65535; noise is in levels of 255 in either case
  double shot_noise = 0;    ///< grey levels per electron
  double hot_pixels = 0;    ///< share of the pixels
  Angle tilt;               ///< of the board against the picture's plane, see Camera
  Angle tilt_axis;
  Length burrs;                       ///< rms of the radius of holes
  Length ring_offset_sigma;           ///< per axis, of holes against their rings
  std::optional<Length> slot_length;  ///< absent: through the whole picture
  DebrisOptions debris;               ///< on each mark
  /// The `$uvis,lamp` at which pictures are as bright as said above; brightness goes with it.
  /// Absent: lamp orders change nothing.
  std::optional<double> lamp;
  /// Where the camera is sharp; unfocused it stands at [camera] focus_mm, or 0. Absent: anywhere.
  std::optional<Length> focus_z;
  Length focus_depth = mm(0.1);   ///< so far from there edges are sqrt(2) times as wide
  SimulatedProbeOptions surface;  ///< of the board, and how well it is probed
  /// [sim.table_surface]: of the table itself, which a night probes.
  std::optional<SimTableSurface> table_surface;
  SimCouponOptions coupon;        ///< [sim.coupon], with the seed of [sim]
  std::optional<SimTable> table;  ///< [sim.table]; absent: the stage stands where it is sent
};

/// When something was measured, and where the machine's file says so.
struct OffsetDate {
  std::chrono::sys_seconds date;
  Place place;
  bool is_utc = false;  ///< false: by the clock on the wall
};

/// [spindle] calibration: where the offset comes from and goes to.
struct SpindleSetting {
  std::filesystem::path file;  ///< empty: [spindle] states the offset itself
  int spindle = 1;             ///< which of the machine's spindles drills, 1 to 12
  int station = 1;             ///< 1 or 2
  /// False: the file is not there yet or does not have this spindle, so that camera_offset_mm only
  /// says where to begin a calibration.
  bool is_calibrated = true;
  /// camera_offset_mm, for any spindle that the file does not have.
  std::optional<Displacement<frame::Machine>> stated_offset;
  SpindleCalibration calibration;  ///< all that the file has
};

/// machine.toml as panelcal uses it. Unknown keys are errors that name the nearest known key.
struct MachineConfig {
  std::filesystem::path file;
  std::string name;
  std::optional<Travel> travel;
  ReadOptions reading;  ///< [program], [[diameter_page]]; without the program's own folder
  /// [vision] rotate, model, mode, cama, scale, default_tool; [gates]; [tolerance]; [program];
  /// [surface]; [reference_scaling]; [table]; [uncertainty], with [spindle], [camera] and [table],
  /// before any drift.
  /// What texts say of the date and the program's name is not in it.
  WalkOptions walk;
  LocateOptions locate;  ///< [vision] scores; centre and radius are set for each picture
  VisionOptions vision;  ///< [vision] search and four views; [camera] focus, lamp
  std::map<int, Target> vision_tools;         ///< [[vision.tool]]
  std::optional<CameraCalibration> camera;    ///< [camera] calibration, read from its own file
  std::filesystem::path camera_file;          ///< of `camera`; empty without
  std::map<double, CameraCalibration> zooms;  ///< [[camera.zoom]], by level
  std::map<double, std::filesystem::path> zoom_files;  ///< of `zooms`
  std::filesystem::path table_file;  ///< [table] calibration, of `walk.table`; or empty
  /// [camera] bayer: picture files are a colour sensor's mosaic as it is, of this pattern.
  std::optional<BayerPattern> bayer;
  SpindleCameraOffset spindle_camera;  ///< [spindle], or of the calibration that it names
  SpindleSetting spindle_setting;
  /// When the offset was calibrated: [spindle] camera_offset_date, or what the calibration says.
  std::optional<OffsetDate> offset_date;
  std::optional<Coupon> coupon;          ///< [coupon]
  std::filesystem::path ledger_file;     ///< [ledger] file; empty without
  std::optional<NightlyConfig> nightly;  ///< [nightly]
  double drift_um_per_sqrt_day = 0;      ///< [uncertainty]: random walk of the offset, per axis
  StageCommands stage;                   ///< [machine] stage_command and its kin, for --camera
  Time settle;                           ///< [machine] settle_s: from an arrival to a picture
  std::optional<GcodeSetting> gcode;     ///< [gcode], for `run --to gcode`
  std::optional<SimConfig> sim;          ///< [sim]
};

/// Larger files are refused unread.
inline constexpr std::size_t kMaxConfigBytes = std::size_t{1} << 20;

/// Reads and validates machine.toml and the calibration files it names (relative to itself).
///
/// Fails  file-unreadable; toml-syntax; config-key-unknown; config-value; not-supported (keys that
///        are planned): each with line, column, the offending text and what was expected; what
///        calibration_file reports
/// See    tests/machine/config/machine_config_test.cc
Expected<MachineConfig> read_machine_config(const std::filesystem::path& file);

/// The same from text; `file` stands in the diagnostics, and calibration files are looked for
/// beside it.
Expected<MachineConfig> parse_machine_config(std::string_view text,
                                             const std::filesystem::path& file);

/// Takes another spindle of [spindle] calibration as the one that drills, as if machine.toml named
/// it. Where it is not calibrated, camera_offset_mm is the start value; without one the
/// present offset stays, which is another spindle's.
///
/// Fails  config-value (there is no such spindle or station)
Expected<void> select_spindle(MachineConfig& config, SpindleAt at);

/// Whether holes may be placed with the offset.
///
/// Fails  config-value (it was never calibrated: see SpindleSetting::is_calibrated)
Expected<void> check_spindle_is_calibrated(const MachineConfig& config);

/// Lets the spindle-camera offset drift from its date to `now`, by the same clock as the date:
///
///   walk.uncertainty.drift_mm2 = drift^2 (now - date) I,   drift in mm per square root of a day
///
/// Until then, and without a date, the offset has not drifted.
/// Fails  config-value (the date is after now)
Expected<void> age_spindle_camera(MachineConfig& config, std::chrono::sys_seconds now);

}  // namespace panelcal
