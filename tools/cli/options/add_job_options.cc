// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include <charconv>
#include <cstdint>
#include <string>

#include "tools/cli/options/command_options.h"
#include "tools/cli/options/program_options.h"
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

void add_threads(CLI::App& command, std::size_t& n_threads) {
  constexpr std::size_t kMaxThreads = 256;
  command
      .add_option(
          "--threads",
          n_threads,
          "Threads that look at pictures or do jobs, 0: one for each processor; no result depends "
          "on their number")
      ->check(CLI::Range(std::size_t{0}, kMaxThreads))
      ->capture_default_str();
}

/// The sources of live measurements: `run` and `serve` have the same words for them.
template <class OptionsOf>
CLI::Option_group* add_source(CLI::App& command, OptionsOf& o) {
  CLI::Option_group* source = command.add_option_group("SOURCE", "Where measurements come from");
  source->add_option("--images", o.images, "Folder with images.csv and pictures");
  source->add_option("--machine-driver", o.machine_driver, "A machine; now: sim")
      ->check(CLI::IsMember({"sim"}));
  source->add_option("--camera",
                     o.camera,
                     "A live camera: folder:DIR, video:FILE, v4l2:DEVICE, rtsp://HOST/PATH or "
                     "gige://ADDRESS");
  return source;
}

void add_valid(CLI::App& command, double& hours) {
  command
      .add_option(
          "--valid", hours, "Hours for which a panel is taken to lie where it was seen last")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
}

CLI::Option* add_alignment(CLI::App& command, AlignOptions& o) {
  return command.add_option("ALIGNMENT", o.alignment, "board.align.json of `panelcal align`")
      ->required();
}

/// Of those that look at pads.
void add_look(CLI::App& command, AlignOptions& o) {
  CLI::Option_group* source = add_source(command, o);
  source->add_option("--measurements", o.measurements, "Recorded measurements (JSON Lines)");
  source->require_option(0, 1);
  command.add_option("--by", o.by, "Who asks (default: the user)");
  add_threads(command, o.n_threads);
}

CLI::Option* add_metrics(CLI::App& command, std::string& metrics) {
  return command.add_option(
      "--metrics", metrics, "Numbers for Prometheus (.prom), for its node exporter");
}

/// A batch on more than one computer.
void add_engine(CLI::App& command, BatchOptions& o) {
  CLI::Option_group* engine = command.add_option_group("ENGINE", "Engine: more than one computer");
  CLI::Option* const kind =
      engine
          ->add_option("--engine",
                       o.engine,
                       "local: this process; slurm: an array of a cluster; parallel: print the "
                       "command of GNU parallel")
          ->check(CLI::IsMember({"local", "slurm", "parallel"}))
          ->capture_default_str();
  engine
      ->add_option("--shards",
                   o.n_shards,
                   "Parts of the batch that slurm or parallel starts, 0: 16, or those under way")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{5'000}))
      ->capture_default_str();
  engine->add_option("--retries", o.n_retries, "Starts of a shard that ended before it was done")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{100}))
      ->capture_default_str();
  engine
      ->add_option("--shard",
                   o.shard,
                   "Only a part of the batch, such as 3/8: what the engines start, also by hand")
      ->excludes(kind)
      ->excludes(command.get_option("--json"))
      ->excludes(command.get_option("--metrics"));
}

}  // namespace

void add_align_options(CLI::App& command, AlignOptions& o) {
  // The commands below it have none of these, so that none is required here.
  CLI::Option* pads = command.add_option(
      "PADS",
      o.pads,
      "Pads to look at: a list \"X,Y;X,Y\" in mm, a Gerber file, a placement file, or a part "
      "program, whose targets of the panel they are");
  command.add_option("-m,--machine", o.machine, "machine.toml");
  add_look(command, o);
  command.add_option("-o,--output", o.output, "The alignment, such as board.align.json");
  command.add_option("--tool",
                     o.vision_tool,
                     "Number of the vision tool that looks for the pads (default: the only one, or "
                     "the one of their size)");
  command
      .add_option("--diameter",
                  o.diameter_mm,
                  "Of the fiducials of a Gerber file without X2 attributes, mm")
      ->check(CLI::PositiveNumber);
  command
      .add_option(
          "--auto",
          o.n_best_holes,
          "Look at this number of a program's own holes, those that determine all others best")
      ->check(CLI::Range(1, 20));
  command.add_option("--panel", o.panel, "Which panel it is, to be kept with the alignment");
  command.add_option("--save-measurements",
                     o.save_measurements,
                     "Write the measurements, to replay with --measurements");
  add_report(command, o.facts, "Write an HTML report");
  add_json(command, o.facts);
  add_reading(command, o.reading, pads);
}

void add_align_verify_options(CLI::App& command, AlignOptions& o) {
  add_alignment(command, o);
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  add_look(command, o);
}

void add_align_show_options(CLI::App& command, AlignOptions& o) {
  add_alignment(command, o);
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  add_valid(command, o.valid_hours);
  add_report(command, o.facts, "Write an HTML report");
  add_json(command, o.facts);
}

void add_check_options(CLI::App& command, CheckOptions& o) {
  command.add_option("PROGRAM", o.program, "Part program; - is standard input");
  command.add_option("-m,--machine", o.machine, "machine.toml");
  add_json(command, o.facts);
  add_clock(command, o.clock);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading);
}

void add_doctor_options(CLI::App& command, DoctorOptions& o) {
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  command.add_option("--camera", o.camera, "Address of the camera (default: that of [nightly])");
  command.add_flag("--devices",
                   o.opens_devices,
                   "Open camera and control too; only while no other program uses them");
  add_json(command, o.facts);
  command.add_option(
      "--clock", o.clock, "Date and time in UTC, such as 2026-11-21T02:00:00Z (default: now)");
}

void add_survey_options(CLI::App& command, SurveyOptions& o) {
  command.add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  add_clock(command, o.clock);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading);
}

void add_plan_options(CLI::App& command, PlanOptions& o) {
  command.add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  add_report(command, o.facts, "The plan as a page that moves with its targets (.html)");
  add_json(command, o.facts);
  command.add_option("--add", o.n_added, "Further targets to propose together")
      ->check(CLI::Range(1, 20))  // plan::kMostAdded
      ->capture_default_str();
  CLI::Option* sigma = command.add_option("--fiducial-sigma-um",
                                          o.fiducial_sigma_um,
                                          "Noise of a target in its picture, along each axis "
                                          "(default: 2)");
  sigma->check(CLI::Range(1e-6, 1e6));
  command.add_option("--measurements", o.measurements, "Take that noise from a recorded job")
      ->excludes(sigma);
  add_clock(command, o.clock);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading);
}

void add_run_options(CLI::App& command, RunOptions& o) {
  command.add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  CLI::Option_group* source = add_source(command, o);
  source->add_option("--measurements", o.measurements, "Recorded measurements (JSON Lines)");
  source->add_option(
      "--align", o.align, "The panel was measured before: board.align.json of `panelcal align`");
  add_valid(command, o.valid_hours);
  source->require_option(0, 1);
  command.add_flag("--uncorrected",
                   o.uncorrected,
                   "The program measures no target: write it as it is, whatever SOURCE says");
  command
      .add_option("--turned",
                  o.turned_deg,
                  "The panel is meant to lie turned by these degrees, counter-clockwise about "
                  "work zero (default: [gates] turned_deg)")
      ->check(CLI::IsMember({0, 90, 180, 270}));
  command.add_option("--probes", o.probes, "Recorded probe readings (JSON Lines)");
  command.add_option("--surface",
                     o.surface,
                     "Map of the board (`panelcal surface fit`): depths below the board count from "
                     "its heights");
  command.add_option("-o,--output",
                     o.output,
                     "Corrected program or picture (.jsonl .csv .drl .exc .s5 .sm .ngc .svg); - "
                     "is standard output");
  command.add_option("--to", o.format, "Output format (default: from the output's extension)")
      ->check(CLI::IsMember({"jsonl", "csv", "excellon", "sieb-meyer", "gcode", "svg"}));
  command
      .add_option("--flavour",
                  o.flavour,
                  "Whose G-code (default: [gcode] flavour, else that of [machine] driver, else "
                  "linuxcnc)")
      ->check(CLI::IsMember({"linuxcnc", "grbl", "marlin"}));
  command
      .add_option("--slots",
                  o.slots,
                  "Pass slots (G85, G87) on whole, or as holes and passes (default: keep for "
                  "excellon, sieb-meyer and svg, expand otherwise; the first two keep G87 in "
                  "any case)")
      ->check(CLI::IsMember({"keep", "expand"}));
  command
      .add_option("--resolution",
                  o.resolution_um,
                  "Write coordinates of excellon and sieb-meyer as fine as this, um (default: "
                  "the control's digits: 1, with inches 2.54)")
      ->check(CLI::PositiveNumber);
  command.add_option(
      "--explain", o.explain, "Explain places: L14 for those of line 14, 500 for the 500th");
  add_report(command, o.facts, "Write an HTML report");
  add_json(command, o.facts);
  command.add_option("--save-measurements",
                     o.save_measurements,
                     "Write the measurements, to replay with --measurements");
  command.add_option(
      "--save-probes", o.save_probes, "Write the probed heights, to replay with --probes");
  add_clock(command, o.clock);
  command.add_option("--truth", o.truth, "Compare with the truth that `synth` wrote");
  add_threads(command, o.n_threads);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading);
  command.add_flag(
      "--force", o.force, "Write the program although a gate or [tolerance] refuses it");
}

void add_translate_options(CLI::App& command, TranslateOptions& o) {
  command.add_option("PROGRAM", o.program, "Part program; - is standard input")->required();
  command.add_option("-o,--output", o.output, "Translated program; - is standard output")
      ->required();
  command.add_option("--to", o.to, "Language to write (default: the other one)")
      ->check(CLI::IsMember({"excellon", "sieb-meyer"}));
  command.add_option("-m,--machine", o.machine, "machine.toml, for zeros and search paths");
  add_clock(command, o.clock);
  add_limit(command, o.max_operations);
  add_reading(command, o.reading);
  command.add_flag(
      "--force", o.force, "Write the program without what decides places or depths and is lost");
}

void add_locate_options(CLI::App& command, LocateCommandOptions& o) {
  command.add_option("IMAGE", o.images, "Pictures")->required();
  CLI::Option* tool = command.add_option("--tool", o.tool, "Number of the vision tool");
  command.add_option("-m,--machine", o.machine, "machine.toml");
  CLI::Option* at = command.add_option("--at", o.at_px, "X,Y: look around this place only, px")
                        ->expected(2)
                        ->delimiter(',');
  CLI::Option* radius =
      command.add_option("--radius", o.radius_px, "How far from --at the centre may be, px");
  at->needs(radius);
  radius->needs(at);
  command.add_option("--overlay",
                     o.overlay,
                     "Draw the fits into the pictures: a .png, or for several pictures a folder");
  CLI::Option* candidates =
      command.add_flag("--candidates",
                       o.lists_candidates,
                       "List the other places that were looked at, and why they do not count");
  CLI::Option* suggest = command.add_flag(
      "--suggest",
      o.suggests,
      "Look for everything that could be a target, and write [[vision.tool]] blocks for it");
  add_json(command, o.facts);
  suggest->excludes(tool)->excludes(candidates);
  command.final_callback([&o] {
    if (o.suggests) return;
    if (!o.tool) throw CLI::RequiredError("--tool");
    if (o.machine.empty()) throw CLI::RequiredError("--machine");
  });
  add_threads(command, o.n_threads);
}

void add_synth_options(CLI::App& command, SynthOptions& o) {
  CLI::Option_group* subject =
      command.add_option_group("SUBJECT", "Subject: a program, one vision tool, or an experiment");
  CLI::Option* program =
      subject->add_option("PROGRAM", o.program, "Part program: all of its targets");
  CLI::Option* tool =
      subject->add_option("--tool", o.tool, "Number of a vision tool: single targets of it");
  CLI::Option* sweep = subject->add_option(
      "--sweep", o.sweep, "A sweep file (docs/formats/sweep.md): a test set of many conditions");
  subject->require_option(1);
  CLI::Option* machine =
      command.add_option("-m,--machine", o.machine, "machine.toml with [sim]")->excludes(sweep);
  command.add_option("-o,--output", o.output, "Folder to write")->required();
  command.add_option("--seed", o.seed, "Instead of [sim] seed")
      ->transform(CLI::Validator(check_seed, "UINT"))
      ->excludes(sweep);
  command
      .add_flag(
          "--resume", o.resume, "With --sweep: go on with a set that was ended, however it was")
      ->needs(sweep);
  add_threads(command, o.n_threads);
  command.get_option("--threads")->needs(sweep);
  command.final_callback([machine, sweep] {
    if (sweep->empty() && machine->empty()) throw CLI::RequiredError("--machine");
  });
  command.add_option("--count", o.count, "With --tool: how many pictures")
      ->check(CLI::Range(1, 100'000))
      ->needs(tool)
      ->capture_default_str();
  add_reading(command, o.reading, program);
}

void add_batch_options(CLI::App& command, BatchOptions& o) {
  command.add_option(
      "MANIFEST", o.manifest, "Jobs, a row each (CSV or JSON Lines); - is standard input");
  command.add_option("--pattern", o.pattern, "Instead, a folder for each job, such as 'jobs/*'");
  command.add_option("-o,--output", o.output, "Folder of the results");
  command.add_option("-m,--machine", o.machine, "machine.toml of jobs that name none");
  command
      .add_option(
          "--to",
          o.format,
          "Output format (default: from each output's extension, or the program's language)")
      ->check(CLI::IsMember({"jsonl", "csv", "excellon", "sieb-meyer", "gcode", "svg"}));
  CLI::Option* resume =
      command.add_flag("--resume", o.resume, "Go on with a batch that was ended, however it was");
  command.add_option("--only", o.only, "Do the jobs that failed, or those that were held, again")
      ->check(CLI::IsMember({"failed", "held"}))
      ->excludes(resume);
  command
      .add_option("--sample",
                  o.n_sampled,
                  "Only this number of jobs, the same ones each time: by a hash of their ids")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  command.add_flag("--places", o.keeps_places, "List every hole in each job's facts.json");
  add_json(command, o.facts);
  add_metrics(command, o.metrics);
  add_store(command, o.store);
  add_clock(command, o.clock);
  add_threads(command, o.n_threads);
  add_engine(command, o);
}

void add_batch_report_options(CLI::App& command, BatchReportOptions& o) {
  command.add_option("RESULTS", o.results, "Folder of the results")->required();
  command.add_option("-o,--output", o.facts.report, "The page (.html)")->required();
  add_json(command, o.facts);
}

void add_batch_merge_options(CLI::App& command, BatchReportOptions& o) {
  add_batch_show_options(command, o);
  add_metrics(command, o.metrics);
}

void add_batch_push_options(CLI::App& command, BatchReportOptions& o) {
  command.add_option("RESULTS", o.results, "Folder of the results")->required();
  add_store(command, o.store)->required();
}

void add_batch_show_options(CLI::App& command, BatchReportOptions& o) {
  command.add_option("RESULTS", o.results, "Folder of the results")->required();
  add_json(command, o.facts);
}

void add_nightly_options(CLI::App& command, NightlyOptions& o) {
  command.add_option("-m,--machine", o.machine, "machine.toml with [nightly] and [ledger]")
      ->required();
  CLI::Option* const dry_run =
      command.add_flag("--dry-run", o.is_dry_run, "Print the steps; move and write nothing");
  command.add_flag("--again", o.is_again, "Calibrate again what this night has calibrated already");
  add_report(command, o.facts, "The report's page (default: [nightly] reports/NIGHT.html)");
  add_json(command, o.facts);
  add_metrics(command, o.metrics)->excludes(dry_run);
  command.add_option("--temperature", o.temperature_c, "Of the machine, degC (default: [nightly])")
      ->check(CLI::Range(-50.0, 100.0));
  command.add_option("--by,--asked-by", o.asked_by, "Who asks (default: the user)");
  command.add_option(
      "--clock", o.clock, "Date and time in UTC, such as 2026-11-21T02:00:00Z (default: now)");
}

void add_serve_options(CLI::App& command, ServeOptions& o) {
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  add_source(command, o)->require_option(1);
  command.add_option(
      "--jobs", o.jobs, "Folder of programs and jobs (default: jobs beside machine.toml)");
  CLI::Option_group* access = command.add_option_group("ACCESS", "Who may look and operate");
  access->add_option("--address", o.address, "HOST:PORT in numbers; port 0: any free one")
      ->capture_default_str();
  access->add_option("--token-file",
                     o.token_file,
                     "Ask for a token; the first start makes it, prints it once and keeps its hash "
                     "in this file. Needed on all addresses but loopback");
  access->add_option("--certificate", o.certificate, "Certificate chain for HTTPS (PEM)");
  access->add_option("--key", o.key, "Key of the certificate (PEM)");
  access->add_option("--host-name",
                     o.host_names,
                     "A name under which browsers call this server, besides its address; repeat it "
                     "for more");
  access->add_flag("--plain-http",
                   o.allows_plain_http,
                   "Let the token pass the network readable, where the network itself is trusted");
}

}  // namespace panelcal
