// SPDX-License-Identifier: Apache-2.0
// The files of this room alone include CLI11: it takes seconds to compile.
#include "tools/cli/options/options.h"

#include <algorithm>
#include <charconv>
#include <iostream>

#include "tools/cli/help/help_text.h"
#include "tools/cli/help/help_topics.h"
#include "tools/cli/options/calibrate_command_line.h"
#include "tools/cli/options/history_command_line.h"
#include "tools/cli/options/parse_problem.h"
#include "tools/cli/options/program_options.h"
#include "tools/cli/options/surface_command_line.h"
#include "tools/cli/process/version.h"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

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
    calibrate_ = add("calibrate", "Calibrate a part of the machine");
    add_calibrate_commands(*calibrate_, calibrate_options_);
    add_nightly();
    history_ = add("history", "Ask a ledger of calibrations, or go back to an earlier one");
    add_history_commands(*history_, history_options_);
    surface_ = add("surface", "Map probed heights, ask the map, and plan where to probe");
    add_surface_commands(*surface_, surface_options_);
    help_ =
        app_.add_subcommand("help",
                            "Explain a command, or list diagnostics, a language's commands or the "
                            "keys of machine.toml");
    help_->add_option("TOPIC",
                      help_topic_,
                      "A command (`run`, `calibrate camera`), `diagnostics`, `excellon`, "
                      "`sieb-meyer`, `machine.toml` or `machine.schema.json`");
  }

  Expected<Options> parse(int argc, char** argv) {
    options_.command_line.assign(argv, argv + argc);
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return refuse(error);
    }
    if (*help_) return help();
    options_.command_name = full_name(command());
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

  void add_check() {
    check_ = add("check", "Read and verify a part program, a machine file, or both");
    check_->add_option("PROGRAM", check_options_.program, "Part program; - is standard input");
    check_->add_option("-m,--machine", check_options_.machine, "machine.toml");
    check_->add_option(
        "--json", check_options_.json, "Write the findings as JSON; - is standard output");
    add_clock(check_, check_options_.clock);
    add_limit(check_, check_options_.max_operations);
    add_reading(check_, check_options_.reading);
  }

  void add_survey() {
    survey_ = add("survey", "List the measurements and probes a program asks for, in order");
    survey_->add_option("PROGRAM", survey_options_.program, "Part program; - is standard input")
        ->required();
    survey_->add_option("-m,--machine", survey_options_.machine, "machine.toml")->required();
    add_clock(survey_, survey_options_.clock);
    add_limit(survey_, survey_options_.max_operations);
    add_reading(survey_, survey_options_.reading);
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
    add_reading(plan_, o.reading);
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
    run_->add_option("--resolution",
                     o.resolution_um,
                     "Write coordinates of excellon and sieb-meyer as fine as this, um (default: "
                     "the control's digits: 1, with inches 2.54)")
        ->check(CLI::PositiveNumber);
    run_->add_option(
        "--explain", o.explain, "Explain places: L14 for those of line 14, 500 for the 500th");
    run_->add_option("--report", o.report, "Write an HTML report");
    run_->add_option("--json", o.json, "Write the report's facts as JSON; - is standard output");
    run_->add_option("--save-measurements",
                     o.save_measurements,
                     "Write the measurements, to replay with --measurements");
    run_->add_option(
        "--save-probes", o.save_probes, "Write the probed heights, to replay with --probes");
    add_clock(run_, o.clock);
    run_->add_option("--truth", o.truth, "Compare with the truth that `synth` wrote");
    add_threads(run_, o.n_threads);
    add_limit(run_, o.max_operations);
    add_reading(run_, o.reading);
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
    add_reading(translate_, o.reading);
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
    add_reading(synth_, synth_options_.reading, program);
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

  /// The last command that the words name, such as `fit` of `panelcal surface fit`.
  const CLI::App& command() const {
    const CLI::App* at = &app_;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
    return *at;
  }

  /// "panelcal surface fit".
  static std::string full_name(const CLI::App& command) {
    const CLI::App* const parent = command.get_parent();
    return parent == nullptr ? command.get_name() : full_name(*parent) + " " + command.get_name();
  }

  Expected<Options> help() {
    options_.command = DoneOptions{};
    if (help_topic_.size() == 1) {
      if (const auto page = panelcal::help_topic(help_topic_.front())) {
        std::cout << *page;
        return std::move(options_);
      }
    }
    const CLI::App* topic = &app_;
    for (const std::string& word : help_topic_) {
      const auto subs = commands_of(*topic);
      const auto found = std::ranges::find(subs, word, &CLI::App::get_name);
      if (found == subs.end()) return failure(unknown_command(*topic, word));
      topic = *found;
    }
    std::cout << topic->help(topic == &app_ ? "" : full_name(*topic->get_parent()));
    return std::move(options_);
  }

  Expected<Options> refuse(const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help or version
      app_.exit(error);
      options_.command = DoneOptions{};
      return std::move(options_);
    }
    const std::vector<std::string> extras = app_.remaining(true);
    if (command().get_require_subcommand_min() > 0) {
      const auto word = std::ranges::find_if(
          extras, [](const std::string& extra) { return !extra.starts_with('-'); });
      if (word != extras.end()) return failure(unknown_command(command(), *word));
    }
    // The name of this error is that of the command.
    const bool has_extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return failure(parse_problem(error.get_name(),
                                 error.what(),
                                 has_extras ? extras : std::vector<std::string>(),
                                 full_name(command())));
  }

  static std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
  }

  static Diagnostic unknown_command(const CLI::App& of, const std::string& word) {
    const auto subs = commands_of(of);
    std::vector<std::string> names(subs.size());
    std::ranges::transform(
        subs, names.begin(), [](const CLI::App* sub) { return sub->get_name(); });
    const std::string_view near =
        nearest_word(word, std::vector<std::string_view>(names.begin(), names.end()));
    return {Code::Usage,
            {full_name(of), 0, 0},
            "unknown command " + quoted(word),
            near.empty() ? fmt::format("one of {}", fmt::join(names, ", "))
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
  std::vector<std::string> help_topic_;
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
