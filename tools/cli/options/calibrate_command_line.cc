// SPDX-License-Identifier: Apache-2.0
// Like options.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/calibrate_command_line.h"

#include <string>

#include "tools/cli/help/help_text.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

class CalibrateCommandLine {
 public:
  CalibrateCommandLine(CLI::App& calibrate, CalibrateOptions& options)
      : calibrate_(calibrate), options_(options) {}

  void add() {
    calibrate_.require_subcommand(1);
    add_calibrate_spindle_camera();
    add_calibrate_camera();
    add_calibrate_table();
    add_calibrate_surface();
    add_calibrate_place();
  }

 private:
  /// One of the things that can be calibrated.
  CLI::App* add_calibration(const char* name, const char* summary, CalibrateOptions::What what) {
    CalibrateOptions& o = options_;
    CLI::App* command = calibrate_.add_subcommand(name, summary);
    command->footer(std::string(command_footer(std::string("calibrate ") + name)));
    command->add_option("-m,--machine", o.machine, "machine.toml")->required();
    command->add_option("-o,--output", o.output, "Write the calibration to this file (.cal.json)");
    add_clock(command);
    command->add_flag("--json", o.json, "One JSON object instead of text");
    command->callback([&o, what] { o.what = what; });
    return command;
  }

  /// SOURCE of those that drive the machine.
  CLI::Option_group* add_devices(CLI::App* command) {
    CalibrateOptions& o = options_;
    CLI::Option_group* source = command->add_option_group("SOURCE", "Source of the pictures");
    source->add_option("--machine-driver", o.machine_driver, "A machine; now: sim")
        ->check(CLI::IsMember({"sim"}));
    source->add_option("--camera",
                       o.camera,
                       "A live camera: folder:DIR, video:FILE, v4l2:DEVICE, rtsp://HOST/PATH or "
                       "gige://ADDRESS; [machine] stage_command moves it");
    source->require_option(1);
    return source;
  }

  /// One of those that are tried at a place and printed; no file comes of them.
  CLI::App* add_trial(const char* name, const char* summary, CalibrateOptions::What what) {
    CalibrateOptions& o = options_;
    CLI::App* command = calibrate_.add_subcommand(name, summary);
    command->footer(std::string(command_footer(std::string("calibrate ") + name)));
    command->add_option("-m,--machine", o.machine, "machine.toml")->required();
    command->add_flag("--json", o.json, "One JSON object instead of text");
    command->add_option("--at", o.at_mm, "X,Y: where a mark lies, machine mm")
        ->expected(2)
        ->delimiter(',')
        ->required();
    command->add_option("--tool", o.tool, "Vision tool of the mark")->capture_default_str();
    add_clock(command);
    add_install(command, "Record it in [ledger] file as the one in force");
    add_devices(command);
    command->callback([&o, what] { o.what = what; });
    return command;
  }

  void add_calibrate_place() {
    using What = CalibrateOptions::What;
    CalibrateOptions& o = options_;
    CLI::App* focus =
        add_trial("focus", "Find the height at which the camera is sharpest", What::Focus);
    focus
        ->add_option("--range", o.range, "LOW,HIGH: heights, mm (default: [camera] focus_range_mm)")
        ->expected(2)
        ->delimiter(',');
    CLI::App* light =
        add_trial("light", "Find the lamp level of best contrast without clipping", What::Light);
    light->add_option("--range", o.range, "LOW,HIGH: lamp levels (default: 10,100)")
        ->expected(2)
        ->delimiter(',');
    light->add_option("--levels", o.n_levels, "Number of lamp levels to try")
        ->check(CLI::Range(3, 1000))
        ->capture_default_str();
    CLI::App* settle = add_trial("settle", "Find how long to wait after a move", What::Settle);
    settle->add_option("--limit-um", o.limit_um, "Error that a picture may still see")
        ->check(CLI::Range(1e-3, 1e6))
        ->capture_default_str();
    settle->add_option("--longest", o.longest_s, "Longest wait that is tried, s")
        ->check(CLI::Range(1e-3, 3600.0))
        ->capture_default_str();
  }

  void add_calibrate_camera() {
    CalibrateOptions& o = options_;
    CLI::App* command =
        add_calibration("camera",
                        "Find scale, rotation, tilt and lens of the camera, from one mark seen all "
                        "over the picture",
                        CalibrateOptions::What::Camera);
    CLI::Option* images = add_devices(command)->add_option(
        "--images", o.images, "Folder with images.csv and pictures of one mark, or of a plate");
    command->add_option("--plate", o.plate, "The pictures show this plate of dots (.toml)")
        ->needs(images);
    command->add_option("--tool", o.tool, "Vision tool of the mark: a disc, hole or ring")
        ->capture_default_str();
    command->add_option("--at", o.at_mm, "X,Y: where the mark lies, machine mm")
        ->expected(2)
        ->delimiter(',');
    command->add_option("--views", o.per_side, "Places along each side of the picture")
        ->check(CLI::Range(3, 21))
        ->capture_default_str();
    command->add_option("--form",
                        o.form,
                        "auto, flat, radial, tilted, tilted-radial or tangential (default: auto, "
                        "the softest that the views determine)");
    command->add_option("--focal-px",
                        o.focal_px,
                        "Distance of the panel over the scale, px (default: a telecentric lens)");
    command->add_option("--zoom", o.zoom, "Level of [[camera.zoom]] to calibrate at");
    command->add_option("--plot", o.plot, "Picture of the residuals (.svg)");
    add_install_by_force(command,
                         "Put it in force: into [ledger] file, then into [camera] calibration");
  }

  void add_install(CLI::App* command, const char* what) {
    CalibrateOptions& o = options_;
    command->add_flag("--install", o.install, what);
    command->add_option("--reason", o.reason, "Why, for those who read the ledger later");
    command->add_option("--by", o.asked_by, "Who asks (default: the user)");
  }

  /// Of those that are held against limits.
  void add_install_by_force(CLI::App* command, const char* what) {
    CalibrateOptions& o = options_;
    add_install(command, what);
    command->add_flag("--force", o.force, "Write or install it although a limit refuses it");
  }

  void add_clock(CLI::App* command) {
    command->add_option("--clock",
                        options_.clock,
                        "Date of the calibration in UTC, such as 2026-11-21T02:00:00Z (default: "
                        "now)");
  }

  void add_calibrate_table() {
    CalibrateOptions& o = options_;
    CLI::App* command = add_calibration("table",
                                        "Find scale, squareness, straightness and the error map of "
                                        "the table, from looks at a plate of dots",
                                        CalibrateOptions::What::Table);
    command->add_option("--plate", o.plate, "The plate: columns, rows, pitch (.toml)")->required();
    CLI::Option_group* source = command->add_option_group("SOURCE", "Looks at the plate");
    source->add_option("--images",
                       o.images,
                       "Folder with images.csv and pictures, or one for each pose: DIR/0, DIR/1, "
                       "...");
    source->add_option("--measurements", o.measurements, "Looks at its dots (JSON Lines)");
    source->require_option(1);
    command->add_option("--plot", o.plot, "Picture of the map (.svg)");
    command->add_option(
        "--linuxcnc", o.linuxcnc, "Folder for matrixkins coefficients and compensation files");
    add_install_by_force(command, "Record it in [ledger] file as the one in force");
  }

  void add_calibrate_surface() {
    CalibrateOptions& o = options_;
    CLI::App* command =
        add_calibration("surface",
                        "Record a map of the table's own surface that was probed by hand",
                        CalibrateOptions::What::Surface);
    command->add_option("MAP", o.map, "The map, of `panelcal surface fit`")->required();
    add_install_by_force(command,
                         "Put it in force: into [ledger] file, then into -o or [nightly.surface] "
                         "file");
  }

  void add_calibrate_spindle_camera() {
    CalibrateOptions& o = options_;
    CLI::App* command = add_calibration("spindle-camera",
                                        "Find where the camera looks against where the spindle "
                                        "drills, from holes in a coupon",
                                        CalibrateOptions::What::SpindleCamera);
    add_devices(command);
    command->add_option("--spindle", o.spindle, "Which spindle drills (default: [spindle] number)")
        ->check(CLI::Range(1, 12));
    command->add_option("--station", o.station, "At which station (default: [spindle] station)")
        ->check(CLI::Range(1, 2));
    command->add_flag("--install",
                      o.install,
                      "Put it in force: into [ledger] file, then into [spindle] calibration");
    command->add_option("--reason", o.reason, "Why, for those who read the ledger later");
    command->add_option("--by", o.asked_by, "Who asks (default: the user)");
    command->add_flag("--yes", o.yes, "Do not ask about entry material: it is dealt with");
    command->add_flag("--force", o.force, "Install although a gate or a trend refuses it");
  }

  CLI::App& calibrate_;
  CalibrateOptions& options_;
};

}  // namespace

void add_calibrate_commands(CLI::App& calibrate, CalibrateOptions& options) {
  CalibrateCommandLine(calibrate, options).add();
}

}  // namespace panelcal
