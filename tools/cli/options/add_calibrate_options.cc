// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/command_options.h"
#include "tools/cli/options/program_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

void add_machine(CLI::App& command, CalibrateOptions& o) {
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
}

/// Of the calibration, not of a program's texts.
void add_date(CLI::App& command, CalibrateOptions& o) {
  command.add_option("--clock",
                     o.clock,
                     "Date of the calibration in UTC, such as 2026-11-21T02:00:00Z (default: "
                     "now)");
}

/// Of each calibration that is a file.
void begin_calibration(CLI::App& command, CalibrateOptions& o) {
  add_machine(command, o);
  command.add_option("-o,--output", o.output, "Write the calibration to this file (.cal.json)");
  add_date(command, o);
  add_json(command, o.facts);
  add_report(command, o.facts, "A page that shows the facts (.html)");
}

/// SOURCE of those that drive the machine.
CLI::Option_group* add_devices(CLI::App& command, CalibrateOptions& o) {
  CLI::Option_group* source = command.add_option_group("SOURCE", "Source of the pictures");
  source->add_option("--machine-driver", o.machine_driver, "A machine; now: sim")
      ->check(CLI::IsMember({"sim"}));
  source->add_option("--camera",
                     o.camera,
                     "A live camera: folder:DIR, video:FILE, v4l2:DEVICE, rtsp://HOST/PATH or "
                     "gige://ADDRESS; [machine] stage_command moves it");
  source->require_option(1);
  return source;
}

void add_max_lens_error(CLI::App& command, CalibrateOptions& o) {
  command
      .add_option("--max-lens-error-px",
                  o.max_lens_error_px,
                  "By which one lens model may miss the other anywhere in the picture")
      ->check(CLI::Range(1e-6, 10.0))
      ->capture_default_str();
}

void add_install(CLI::App& command, CalibrateOptions& o, const char* what) {
  command.add_flag("--install", o.install, what);
  command.add_option("--reason", o.reason, "Why, for those who read the ledger later");
  command.add_option("--by", o.asked_by, "Who asks (default: the user)");
}

/// Of those that are held against limits.
void add_install_by_force(CLI::App& command, CalibrateOptions& o, const char* what) {
  add_install(command, o, what);
  command.add_flag("--force", o.force, "Write or install it although a limit refuses it");
}

/// Of those that are tried at a place and printed; no file comes of them.
void begin_trial(CLI::App& command, CalibrateOptions& o) {
  add_machine(command, o);
  add_json(command, o.facts);
  add_report(command, o.facts, "A page that shows the facts (.html)");
  command.add_option("--at", o.at_mm, "X,Y: where a mark lies, machine mm")
      ->expected(2)
      ->delimiter(',')
      ->required();
  command.add_option("--tool", o.tool, "Vision tool of the mark")->capture_default_str();
  add_date(command, o);
  add_install(command, o, "Record it in [ledger] file as the one in force");
  add_devices(command, o);
}

}  // namespace

void add_calibrate_spindle_camera_options(CLI::App& command, CalibrateOptions& o) {
  begin_calibration(command, o);
  add_devices(command, o);
  command.add_option("--spindle", o.spindle, "Which spindle drills (default: [spindle] number)")
      ->check(CLI::Range(1, 12));
  command.add_option("--station", o.station, "At which station (default: [spindle] station)")
      ->check(CLI::Range(1, 2));
  add_install(command, o, "Put it in force: into [ledger] file, then into [spindle] calibration");
  command.add_flag("--yes", o.yes, "Do not ask about entry material: it is dealt with");
  command.add_flag("--force", o.force, "Install although a gate or a trend refuses it");
}

void add_calibrate_camera_options(CLI::App& command, CalibrateOptions& o) {
  begin_calibration(command, o);
  CLI::Option* images =
      add_devices(command, o)
          ->add_option("--images",
                       o.images,
                       "Folder with images.csv and pictures of one mark, or of a plate");
  command.add_option("--plate", o.plate, "The pictures show this plate of dots (.toml)")
      ->needs(images);
  command.add_option("--tool", o.tool, "Vision tool of the mark: a disc, hole or ring")
      ->capture_default_str();
  command.add_option("--at", o.at_mm, "X,Y: where the mark lies, machine mm")
      ->expected(2)
      ->delimiter(',');
  command.add_option("--views", o.per_side, "Places along each side of the picture")
      ->check(CLI::Range(3, 21))
      ->capture_default_str();
  command.add_option("--form",
                     o.form,
                     "auto, flat, radial, tilted, tilted-radial or tangential (default: auto, "
                     "the softest that the views determine)");
  command.add_option("--focal-px",
                     o.focal_px,
                     "Distance of the panel over the scale, px (default: a telecentric lens)");
  command.add_option("--zoom", o.zoom, "Level of [[camera.zoom]] to calibrate at");
  add_install_by_force(
      command, o, "Put it in force: into [ledger] file, then into [camera] calibration");
}

void add_calibrate_camera_import_options(CLI::App& command, CalibrateOptions& o) {
  command.add_option("MODEL", o.exchange_file, "OpenCV's YAML, ROS' camera_info, or .cameramodel")
      ->required();
  command.add_option("-o,--output", o.output, "The calibration (.cal.json)")->required();
  CLI::Option_group* scale = command.add_option_group("SCALE", "What no lens model says");
  scale->add_option("--scale-mm-per-px", o.scale_mm_per_px, "Of the panel on the optical axis")
      ->check(CLI::Range(1e-6, 1e3));
  scale
      ->add_option(
          "--distance-mm", o.distance_mm, "Of the panel from the lens: scale times focal length")
      ->check(CLI::Range(1e-3, 1e6));
  scale->require_option(1);
  command.add_option("--rotation-deg", o.rotation_deg, "Of the picture against the machine")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command
      .add_option("--corner-sigma-um",
                  o.corner_sigma_um,
                  "How far off a place in the picture's farthest corner may be (one sigma)")
      ->required()
      ->check(CLI::Range(1e-3, 1e6));
  add_max_lens_error(command, o);
  add_date(command, o);
}

void add_calibrate_camera_export_options(CLI::App& command, CalibrateOptions& o) {
  command.add_option("CALIBRATION", o.exchange_file, "A camera's calibration (.cal.json)")
      ->required();
  command.add_option("--to", o.exchange_format, "Whose file to write")
      ->required()
      ->check(CLI::IsMember({"opencv", "ros", "mrcal"}));
  command.add_option("-o,--output", o.output, "The file; - is standard output")->required();
  command
      .add_option("--focal-px", o.focal_px, "Focal length, of a telecentric camera (any will do)")
      ->check(CLI::Range(1.0, 1e7));
  add_max_lens_error(command, o);
}

void add_calibrate_table_options(CLI::App& command, CalibrateOptions& o) {
  begin_calibration(command, o);
  o.installed_key = "table.calibration";
  command.add_option("--plate", o.plate, "The plate: columns, rows, pitch (.toml)")->required();
  CLI::Option_group* source = command.add_option_group("SOURCE", "Looks at the plate");
  source->add_option("--images",
                     o.images,
                     "Folder with images.csv and pictures, or one for each pose: DIR/0, DIR/1, "
                     "...");
  source->add_option("--measurements", o.measurements, "Looks at its dots (JSON Lines)");
  source->require_option(1);
  command.add_option(
      "--linuxcnc", o.linuxcnc, "Folder for matrixkins coefficients and compensation files");
  add_install_by_force(command, o, "Record it in [ledger] file as the one in force");
}

void add_calibrate_surface_options(CLI::App& command, CalibrateOptions& o) {
  begin_calibration(command, o);
  o.installed_key = "nightly.surface.file";
  command.add_option("MAP", o.map, "The map, of `panelcal surface fit`")->required();
  add_install_by_force(command,
                       o,
                       "Put it in force: into [ledger] file, then into -o or [nightly.surface] "
                       "file");
}

void add_calibrate_focus_options(CLI::App& command, CalibrateOptions& o) {
  begin_trial(command, o);
  command
      .add_option("--range", o.range, "LOW,HIGH: heights, mm (default: [camera] focus_range_mm)")
      ->expected(2)
      ->delimiter(',');
}

void add_calibrate_light_options(CLI::App& command, CalibrateOptions& o) {
  begin_trial(command, o);
  command.add_option("--range", o.range, "LOW,HIGH: lamp levels (default: 10,100)")
      ->expected(2)
      ->delimiter(',');
  command.add_option("--levels", o.n_levels, "Number of lamp levels to try")
      ->check(CLI::Range(3, 1000))
      ->capture_default_str();
}

void add_calibrate_settle_options(CLI::App& command, CalibrateOptions& o) {
  begin_trial(command, o);
  command.add_option("--limit-um", o.limit_um, "Error that a picture may still see")
      ->check(CLI::Range(1e-3, 1e6))
      ->capture_default_str();
  command.add_option("--longest", o.longest_s, "Longest wait that is tried, s")
      ->check(CLI::Range(1e-3, 3600.0))
      ->capture_default_str();
}

}  // namespace panelcal
