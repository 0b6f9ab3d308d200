// SPDX-License-Identifier: Apache-2.0
// With surface_command_line.cc the only file that includes CLI11: it takes seconds to compile.
#include "tools/cli/options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iostream>

#include "tools/cli/help_text.h"
#include "tools/cli/help_topics.h"
#include "tools/cli/parse_problem.h"
#include "tools/cli/surface_command_line.h"
#include "tools/cli/version.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

/// Makes sure that a text is a number from 0 in digits: CLI11 would wrap -1 around, and read 010 as
/// eight. What is wrong, or nothing.
std::string check_seed(std::string& text) {
  std::uint64_t seed = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, seed);
  if (read.ec != std::errc() || read.ptr != end) {
    return text + " not in range 0 to 18446744073709551615";
  }
  text = std::to_string(seed);
  return {};
}

class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", std::string("panelcal ") + kVersion);
    app_.footer(std::string(kMainFooter));
    app_.fallthrough();
    app_.add_flag("-q,--quiet", options_.common.quiet, "Errors only on standard error");
    app_.add_option("--log-level", options_.common.log_level, "Level of messages on standard error")
        ->check(CLI::IsMember({"error", "warning", "info"}))
        ->capture_default_str();
    add_check();
    add_survey();
    add_plan();
    add_run();
    add_translate();
    add_locate();
    add_synth();
    add_calibrate();
    add_nightly();
    add_history();
    surface_ = add("surface", "Map probed heights, ask the map, and plan where to probe");
    add_surface_commands(*surface_, surface_options_);
    help_ = app_.add_subcommand("help",
                                "Explain a command, or list diagnostics or a language's commands");
    help_->add_option("TOPIC", help_topic_, "A command, `diagnostics`, `excellon` or `sieb-meyer`");
  }

  Expected<Options> parse(int argc, char** argv) {
    options_.command_line.assign(argv, argv + argc);
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return refuse(error);
    }
    if (*help_) return help();
    options_.command_name = app_.get_name();
    for (const CLI::App* at = &app_; !at->get_subcommands().empty();) {
      at = at->get_subcommands().front();
      options_.command_name += " " + at->get_name();
    }
    options_.files = file_options(app_);
    if (*check_) options_.command = check_options_;
    if (*survey_) options_.command = survey_options_;
    if (*plan_) options_.command = plan_options_;
    if (*run_) options_.command = run_options_;
    if (*translate_) options_.command = translate_options_;
    if (*locate_) options_.command = locate_options_;
    if (*synth_) options_.command = synth_options_;
    if (*calibrate_) options_.command = calibrate_options_;
    if (*nightly_) options_.command = nightly_options_;
    if (*history_) options_.command = history_options_;
    if (*surface_) options_.command = surface_options_;
    return std::move(options_);
  }

 private:
  CLI::App* add(const char* name, const char* summary) {
    CLI::App* command = app_.add_subcommand(name, summary);
    command->footer(std::string(command_footer(name)));
    return command;
  }

  static void add_limit(CLI::App* command, std::int64_t& max_operations) {
    constexpr std::int64_t kMost = 1'000'000'000'000;
    command->add_option("--max-operations", max_operations, "Stop a program that never ends")
        ->check(CLI::Range(std::int64_t{1}, kMost))
        ->capture_default_str();
  }

  static CLI::Option* add_accept(CLI::App* command, bool& accepts_unterminated) {
    return command->add_flag(
        "--accept-unterminated", accepts_unterminated, kAcceptUnterminatedHelp);
  }

  static void add_threads(CLI::App* command, std::size_t& n_threads) {
    constexpr std::size_t kMaxThreads = 256;
    command
        ->add_option("--threads",
                     n_threads,
                     "Threads that look at pictures, 0: one for each processor; no result depends "
                     "on their number")
        ->check(CLI::Range(std::size_t{0}, kMaxThreads))
        ->capture_default_str();
  }

  static void add_clock(CLI::App* command, std::string& clock) {
    command->add_option("--clock",
                        clock,
                        "Date and time for texts (&D, &T), for the report and for the age of "
                        "[spindle] camera_offset_date, such as 2026-11-21T13:45:00 (default: now)");
  }

  void add_check() {
    check_ = add("check", "Read and verify a part program, a machine file, or both");
    check_->add_option("PROGRAM", check_options_.program, "Part program; - is standard input");
    check_->add_option("-m,--machine", check_options_.machine, "machine.toml");
    add_clock(check_, check_options_.clock);
    add_limit(check_, check_options_.max_operations);
    add_accept(check_, check_options_.accepts_unterminated);
  }

  void add_survey() {
    survey_ = add("survey", "List the measurements and probes a program asks for, in order");
    survey_->add_option("PROGRAM", survey_options_.program, "Part program; - is standard input")
        ->required();
    survey_->add_option("-m,--machine", survey_options_.machine, "machine.toml")->required();
    add_clock(survey_, survey_options_.clock);
    add_limit(survey_, survey_options_.max_operations);
    add_accept(survey_, survey_options_.accepts_unterminated);
  }

  void add_plan() {
    plan_ =
        add("plan", "Predict before the job how sure its targets make every hole, and what helps");
    PlanOptions& o = plan_options_;
    plan_->add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
    plan_->add_option("-m,--machine", o.machine, "machine.toml")->required();
    plan_->add_option("-o,--output", o.output, "Picture of the plan (.svg), or a page (.html)");
    plan_->add_flag("--json", o.json, "One JSON object instead of text");
    plan_->add_option("--add", o.n_added, "Further targets to propose together")
        ->check(CLI::Range(1, 20))
        ->capture_default_str();
    CLI::Option* sigma = plan_->add_option("--fiducial-sigma-um",
                                           o.fiducial_sigma_um,
                                           "Noise of a target in its picture, along each axis "
                                           "(default: 2)");
    sigma->check(CLI::Range(1e-6, 1e6));
    plan_->add_option("--measurements", o.measurements, "Take that noise from a recorded job")
        ->excludes(sigma);
    add_clock(plan_, o.clock);
    add_limit(plan_, o.max_operations);
    add_accept(plan_, o.accepts_unterminated);
  }

  void add_run() {
    run_ = add("run", "Measure, fit, gate, correct and write a program");
    RunOptions& o = run_options_;
    run_->add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
    run_->add_option("-m,--machine", o.machine, "machine.toml")->required();
    CLI::Option_group* source = run_->add_option_group("SOURCE", "Where measurements come from");
    source->add_option("--images", o.images, "Folder with images.csv and pictures");
    source->add_option("--measurements", o.measurements, "Recorded measurements (JSON Lines)");
    source->add_option("--machine-driver", o.machine_driver, "A machine; now: sim")
        ->check(CLI::IsMember({"sim"}));
    source->add_option("--camera",
                       o.camera,
                       "A live camera: folder:DIR, video:FILE, v4l2:DEVICE, rtsp://HOST/PATH or "
                       "gige://ADDRESS");
    source->require_option(0, 1);
    run_->add_flag("--uncorrected",
                   o.uncorrected,
                   "The program measures no target: write it as it is, whatever SOURCE says");
    run_->add_option("--turned",
                     o.turned_deg,
                     "The panel is meant to lie turned by these degrees, counter-clockwise about "
                     "work zero (default: [gates] turned_deg)")
        ->check(CLI::IsMember({0, 90, 180, 270}));
    run_->add_option("--probes", o.probes, "Recorded probe readings (JSON Lines)");
    run_->add_option("--surface",
                     o.surface,
                     "Map of the board (`panelcal surface fit`): depths below the board count from "
                     "its heights");
    run_->add_option("-o,--output",
                     o.output,
                     "Corrected program or picture (.jsonl .csv .drl .exc .s5 .sm .ngc .svg); - "
                     "is standard output");
    run_->add_option("--to", o.format, "Output format (default: from the output's extension)")
        ->check(CLI::IsMember({"jsonl", "csv", "excellon", "sieb-meyer", "gcode", "svg"}));
    run_->add_option("--slots",
                     o.slots,
                     "Pass slots (G85, G87) on whole, or as holes and passes (default: keep for "
                     "excellon, sieb-meyer and svg, expand otherwise; the first two keep G87 in "
                     "any case)")
        ->check(CLI::IsMember({"keep", "expand"}));
    run_->add_option(
        "--explain", o.explain, "Explain places: L14 for those of line 14, 500 for the 500th");
    run_->add_option("--report", o.report, "Write an HTML report");
    run_->add_option("--save-measurements",
                     o.save_measurements,
                     "Write the measurements, to replay with --measurements");
    run_->add_option(
        "--save-probes", o.save_probes, "Write the probed heights, to replay with --probes");
    add_clock(run_, o.clock);
    run_->add_option("--truth", o.truth, "Compare with the truth that `synth` wrote");
    add_threads(run_, o.n_threads);
    add_limit(run_, o.max_operations);
    add_accept(run_, o.accepts_unterminated);
    run_->add_flag(
        "--force", o.force, "Write the program although a gate or [tolerance] refuses it");
  }

  void add_translate() {
    translate_ = add("translate", "Write a program in the other language, patterns and all");
    TranslateOptions& o = translate_options_;
    translate_->add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
    translate_->add_option("-o,--output", o.output, "Translated program; - is standard output")
        ->required();
    translate_->add_option("--to", o.to, "Language to write (default: the other one)")
        ->check(CLI::IsMember({"excellon", "sieb-meyer"}));
    translate_->add_option("-m,--machine", o.machine, "machine.toml, for zeros and search paths");
    add_clock(translate_, o.clock);
    add_limit(translate_, o.max_operations);
    add_accept(translate_, o.accepts_unterminated);
    translate_->add_flag(
        "--force", o.force, "Write the program without what decides places or depths and is lost");
  }

  void add_locate() {
    locate_ = add("locate", "Find a target in pictures");
    locate_->add_option("IMAGE", locate_options_.images, "Pictures")->required();
    CLI::Option* tool =
        locate_->add_option("--tool", locate_options_.tool, "Number of the vision tool");
    locate_->add_option("-m,--machine", locate_options_.machine, "machine.toml");
    CLI::Option* at =
        locate_->add_option("--at", locate_options_.at_px, "X,Y: look around this place only, px")
            ->expected(2)
            ->delimiter(',');
    CLI::Option* radius = locate_->add_option(
        "--radius", locate_options_.radius_px, "How far from --at the centre may be, px");
    at->needs(radius);
    radius->needs(at);
    locate_->add_option(
        "--overlay",
        locate_options_.overlay,
        "Draw the fits into the pictures: a .png, or for several pictures a folder");
    CLI::Option* candidates =
        locate_->add_flag("--candidates",
                          locate_options_.lists_candidates,
                          "List the other places that were looked at, and why they do not count");
    CLI::Option* suggest = locate_->add_flag(
        "--suggest",
        locate_options_.suggests,
        "Look for everything that could be a target, and write [[vision.tool]] blocks for it");
    locate_->add_flag("--json", locate_options_.json, "The suggestion as JSON Lines")
        ->needs(suggest);
    suggest->excludes(tool)->excludes(candidates);
    locate_->final_callback([this] {
      if (locate_options_.suggests) return;
      if (!locate_options_.tool) throw CLI::RequiredError("--tool");
      if (locate_options_.machine.empty()) throw CLI::RequiredError("--machine");
    });
    add_threads(locate_, locate_options_.n_threads);
  }

  void add_synth() {
    synth_ = add("synth", "Render the pictures a program asks for, with their truth");
    CLI::Option_group* subject =
        synth_->add_option_group("SUBJECT", "Subject: a program, or one vision tool");
    CLI::Option* program =
        subject->add_option("PROGRAM", synth_options_.program, "Part program: all of its targets");
    CLI::Option* tool = subject->add_option(
        "--tool", synth_options_.tool, "Number of a vision tool: single targets of it");
    subject->require_option(1);
    synth_->add_option("-m,--machine", synth_options_.machine, "machine.toml with [sim]")
        ->required();
    synth_->add_option("-o,--output", synth_options_.output, "Folder to write")->required();
    synth_->add_option("--seed", synth_options_.seed, "Instead of [sim] seed")
        ->transform(CLI::Validator(check_seed, "UINT"));
    synth_->add_option("--count", synth_options_.count, "With --tool: how many pictures")
        ->check(CLI::Range(1, 100'000))
        ->needs(tool)
        ->capture_default_str();
    add_accept(synth_, synth_options_.accepts_unterminated)->needs(program);
  }

  /// One of the things that can be calibrated.
  CLI::App* add_calibration(const char* name, const char* summary, CalibrateOptions::What what) {
    CalibrateOptions& o = calibrate_options_;
    CLI::App* command = calibrate_->add_subcommand(name, summary);
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
    CalibrateOptions& o = calibrate_options_;
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

  void add_calibrate() {
    calibrate_ = add("calibrate", "Calibrate a part of the machine");
    calibrate_->require_subcommand(1);
    add_calibrate_spindle_camera();
    add_calibrate_camera();
    add_calibrate_table();
    add_calibrate_surface();
    add_calibrate_place();
  }

  /// One of those that are tried at a place and printed; no file comes of them.
  CLI::App* add_trial(const char* name, const char* summary, CalibrateOptions::What what) {
    CalibrateOptions& o = calibrate_options_;
    CLI::App* command = calibrate_->add_subcommand(name, summary);
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
    CalibrateOptions& o = calibrate_options_;
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
    CalibrateOptions& o = calibrate_options_;
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
                        "the stiffest that the views do not contradict)");
    command->add_option("--focal-px",
                        o.focal_px,
                        "Distance of the panel over the scale, px (default: a telecentric lens)");
    command->add_option("--zoom", o.zoom, "Level of [[camera.zoom]] to calibrate at");
    command->add_option("--plot", o.plot, "Picture of the residuals (.svg)");
    add_install_by_force(command,
                         "Put it in force: into [ledger] file, then into [camera] calibration");
  }

  void add_install(CLI::App* command, const char* what) {
    CalibrateOptions& o = calibrate_options_;
    command->add_flag("--install", o.install, what);
    command->add_option("--reason", o.reason, "Why, for those who read the ledger later");
    command->add_option("--by", o.asked_by, "Who asks (default: the user)");
  }

  /// Of those that are held against limits.
  void add_install_by_force(CLI::App* command, const char* what) {
    CalibrateOptions& o = calibrate_options_;
    add_install(command, what);
    command->add_flag("--force", o.force, "Write or install it although a limit refuses it");
  }

  void add_clock(CLI::App* command) {
    command->add_option("--clock",
                        calibrate_options_.clock,
                        "Date of the calibration in UTC, such as 2026-11-21T02:00:00Z (default: "
                        "now)");
  }

  void add_calibrate_table() {
    CalibrateOptions& o = calibrate_options_;
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
    CalibrateOptions& o = calibrate_options_;
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
    CalibrateOptions& o = calibrate_options_;
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

  void add_nightly() {
    NightlyOptions& o = nightly_options_;
    nightly_ = add("nightly", "Calibrate the machine at night without a person, and report");
    nightly_->add_option("-m,--machine", o.machine, "machine.toml with [nightly] and [ledger]")
        ->required();
    nightly_->add_flag("--dry-run", o.is_dry_run, "Print the steps; move and write nothing");
    nightly_->add_flag(
        "--again", o.is_again, "Calibrate again what this night has calibrated already");
    nightly_->add_option(
        "--report", o.report, "The report's page (default: [nightly] reports/NIGHT.html)");
    nightly_->add_option("--json", o.json, "The same for programs; - is standard output");
    nightly_
        ->add_option("--temperature", o.temperature_c, "Of the machine, degC (default: [nightly])")
        ->check(CLI::Range(-50.0, 100.0));
    nightly_->add_option("--by,--asked-by", o.asked_by, "Who asks (default: the user)");
    nightly_->add_option(
        "--clock", o.clock, "Date and time in UTC, such as 2026-11-21T02:00:00Z (default: now)");
  }

  /// One of history's own commands.
  CLI::App* add_action(const char* name, const char* summary, HistoryOptions::Action action) {
    HistoryOptions& o = history_options_;
    CLI::App* command = history_->add_subcommand(name, summary);
    command->add_option("-l,--ledger", o.ledger, "The ledger's file")->required();
    command->add_option("-o,--output", o.output, "Write to this file, whole or not at all");
    command->callback([&o, action] { o.action = action; });
    return command;
  }

  void add_key(CLI::App* command, bool required) {
    HistoryOptions& o = history_options_;
    command->add_option("--machine", o.machine, "The machine's name")->required(required);
    command->add_option("--kind", o.kind, "spindle-camera, camera, table, ...")->required(required);
    command->add_option("--subject", o.subject, "Which of that kind, such as \"zoom 3\"")
        ->required(required);
  }

  void add_history() {
    using Action = HistoryOptions::Action;
    HistoryOptions& o = history_options_;
    history_ = add("history", "Ask a ledger of calibrations, or go back to an earlier one");
    history_->require_subcommand(1);
    CLI::App* list = add_action("list", "Entries, one a line; * is in force", Action::List);
    CLI::App* dump = add_action("export", "Everything as JSON Lines", Action::Export);
    for (CLI::App* command : {list, dump}) {
      add_key(command, false);
      command->add_option("--since", o.since, "Not older: 2026-11-21, or with T08:37:38Z (UTC)");
      command->add_option("--last", o.last, "Only the newest N")
          ->check(CLI::Range(1, 1'000'000'000));
    }
    CLI::App* show = add_action("show", "One entry", Action::Show);
    show->add_option("ID", o.ids, "Its number")->required()->expected(1);
    show->add_flag("--result", o.result, "The calibration itself, byte for byte");
    CLI::App* diff = add_action("diff", "What changed from one entry to another", Action::Diff);
    add_diff_of_job(diff);
    CLI::App* back = add_action("rollback", "Put an earlier one in force", Action::RollBack);
    add_key(back, true);
    back->add_option("--to", o.to, "Entry to go back to (default: the one before)");
    back->add_option("--reason", o.reason, "Why, for those who read it later")->required();
    back->add_option("--by", o.asked_by, "Who asks (default: the user)");
    CLI::App* fresh = add_action("fresh-start",
                                 "Record that later nights are not compared with earlier ones",
                                 Action::FreshStart);
    add_key(fresh, true);
    fresh->add_option("--reason", o.reason, "Reason: the part that was changed or examined")
        ->required();
    fresh->add_option("--by", o.asked_by, "Name of the person (default: the user)");
    CLI::App* plot = add_action("plot", "One parameter over time, as SVG", Action::Plot);
    add_key(plot, true);
    plot->add_option("--parameter", o.parameter, "Its name, as `show` lists it")->required();
    CLI::App* verify = add_action("verify", "Check every hash of the ledger", Action::Verify);
    for (CLI::App* command : {list, show, diff, back, fresh, verify}) {
      command->add_flag("--json", o.json, "JSON instead of text");
    }
  }

  void add_diff_of_job(CLI::App* diff) {
    HistoryOptions& o = history_options_;
    diff->add_option("ID", o.ids, "Two numbers: before and after")->required()->expected(2);
    CLI::Option* program =
        diff->add_option("--program",
                         o.program,
                         "Show how far every hole of this job would move; -o is its picture");
    CLI::Option* machine = diff->add_option("-m,--machine", o.machine_file, "machine.toml");
    program->needs(machine);
    machine->needs(program);
    diff->add_option("--measurements",
                     o.measurements,
                     "Of cameras: a recorded job, for where in the picture targets were seen")
        ->needs(program);
    add_clock(diff, o.clock);
    add_limit(diff, o.max_operations);
    add_accept(diff, o.accepts_unterminated)->needs(program);
  }

  Expected<Options> help() {
    options_.command = DoneOptions{};
    if (const auto page = panelcal::help_topic(help_topic_)) {
      std::cout << *page;
      return std::move(options_);
    }
    const CLI::App* topic = &app_;
    if (!help_topic_.empty()) {
      const auto commands = app_.get_subcommands([](const CLI::App*) { return true; });
      const auto found = std::ranges::find_if(
          commands, [&](const CLI::App* command) { return command->get_name() == help_topic_; });
      if (found == commands.end()) return failure(unknown_command(help_topic_));
      topic = *found;
    }
    std::cout << topic->help(topic == &app_ ? "" : app_.get_name());
    return std::move(options_);
  }

  Expected<Options> refuse(const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help or version
      app_.exit(error);
      options_.command = DoneOptions{};
      return std::move(options_);
    }
    if (options_.command_line.size() > 1 && app_.get_subcommands().empty() &&
        options_.command_line[1].front() != '-') {
      return failure(unknown_command(options_.command_line[1]));
    }
    const auto commands = app_.get_subcommands();
    const std::string command = commands.empty() ? "" : " " + commands.front()->get_name();
    // The name of this error is that of the command.
    const bool has_extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return failure(parse_problem(error.get_name(),
                                 error.what(),
                                 has_extras ? app_.remaining(true) : std::vector<std::string>(),
                                 "panelcal" + command));
  }

  static Diagnostic unknown_command(const std::string& word) {
    constexpr std::array<std::string_view, 12> kCommands = {"check",
                                                            "survey",
                                                            "plan",
                                                            "run",
                                                            "translate",
                                                            "locate",
                                                            "synth",
                                                            "calibrate",
                                                            "nightly",
                                                            "history",
                                                            "surface",
                                                            "help"};
    const std::string_view near = nearest_word(word, kCommands);
    return {Code::Usage,
            {"panelcal", 0, 0},
            "unknown command " + quoted(word),
            near.empty()
                ? "check, survey, plan, run, translate, locate, synth, calibrate, nightly, "
                  "history, surface or help"
                : "did you mean " + quoted(near) + "?"};
  }

  CLI::App app_{std::string(kMainHeader), "panelcal"};
  Options options_;
  CheckOptions check_options_;
  SurveyOptions survey_options_;
  PlanOptions plan_options_;
  RunOptions run_options_;
  TranslateOptions translate_options_;
  LocateCommandOptions locate_options_;
  SynthOptions synth_options_;
  NightlyOptions nightly_options_;
  CalibrateOptions calibrate_options_;
  HistoryOptions history_options_;
  SurfaceOptions surface_options_;
  std::string help_topic_;
  CLI::App* check_ = nullptr;
  CLI::App* survey_ = nullptr;
  CLI::App* plan_ = nullptr;
  CLI::App* run_ = nullptr;
  CLI::App* translate_ = nullptr;
  CLI::App* locate_ = nullptr;
  CLI::App* synth_ = nullptr;
  CLI::App* nightly_ = nullptr;
  CLI::App* calibrate_ = nullptr;
  CLI::App* history_ = nullptr;
  CLI::App* surface_ = nullptr;
  CLI::App* help_ = nullptr;
};

}  // namespace

Expected<Options> parse_options(int argc, char** argv) {
  return CommandLine().parse(argc, argv);
}

}  // namespace panelcal
