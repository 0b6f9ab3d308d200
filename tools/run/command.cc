// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/interruption.h"
#include "calib/base/thread_pool.h"
#include "machine/align/measure.h"
#include "machine/config/machine_config.h"
#include "machine/job/camera_pose.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/facts/seen_pictures.h"
#include "machine/job/job.h"
#include "machine/job/summary/depth_summary.h"
#include "machine/job/summary/verdict_summary.h"
#include "machine/job/text_variables.h"
#include "machine/nightly/record/noted_heads.h"
#include "machine/sim/truth.h"
#include "surface/map/file.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/operator_prompt.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/run/fits_summary.h"
#include "vision/suggest/common_scale.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

constexpr const char* kCommand = "panelcal run";

Diagnostic usage(std::string what, std::string expected) {
  return {Code::Usage, {kCommand, 0, 0}, std::move(what), std::move(expected)};
}

/// To whole seconds.
std::chrono::seconds hours(double hours) {
  return std::chrono::seconds(static_cast<std::int64_t>(std::llround(hours * 3600)));
}

Expected<OutputFormat> output_format(const RunOptions& options) {
  const auto format = options.format.empty()
                          ? output_format_of_extension(extension_of(options.output))
                          : output_format_from_name(options.format);
  if (format) return *format;
  return failure(usage("no format belongs to the output's name " + quoted(options.output),
                       ".jsonl, .csv, .drl, .exc, .s5, .sm, .ngc or .svg, or --to"));
}

/// Choice of --explain; without it there has to be an output.
Expected<std::optional<ExplainChoice>> explain_choice(const RunOptions& options) {
  if (options.explain.empty()) {
    if (!options.output.empty()) return std::nullopt;
    return failure(usage("there is nothing to write", "-o OUTPUT, or --explain"));
  }
  const auto choice = parse_explain_choice(options.explain);
  if (!choice) {
    return failure(usage("--explain " + quoted(options.explain),
                         "L and a line, such as L14, or the number of a place from 1"));
  }
  if (options.output.empty() && options.facts.any()) {
    const std::string_view option = options.facts.report.empty() ? "--json" : "--report";
    return failure(usage(fmt::format("{} without an output", option), "-o OUTPUT as well"));
  }
  return choice;
}

/// From options to a job, and from its result to people. Every stage leaves its problems in log_.
class RunCommand {
 public:
  RunCommand(const RunOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  ExitCode run() {
    if (!options_.camera.empty()) heed_interruptions();
    if (Expected<void> ready = prepare(); !ready) {
      log_.add(std::move(ready).error());
      return finish();
    }
    const JobSinks sinks{
        .output = output_.get(),
        .progress = [this](std::string_view text) { context_.console.progress(text); },
        .end_progress = [this](std::string_view remark) { end_progress(remark); },
        .measured = [this](const Survey& survey) { return tell_measured(survey); },
        .log = &log_};
    const OpenJobSources open = [this](const Survey& nominal) {
      if (!options_.images.empty()) {
        pool_ = make_thread_pool(options_.n_threads, nominal.measurements.size());
      }
      Expected<JobSources> sources = open_sources(source_choice(), machine_, nominal);
      if (sources && job_.aligned) sources->words = aligned_words_;
      return sources;
    };
    if (const Expected<JobResult> result = correct(job_, open, machine_, sinks)) {
      is_written_ = result->is_committed;
      tell(*result);
      explain_refused_fits(*result->survey);
      state(*result);
    }
    return finish();
  }

 private:
  bool take(Expected<void> done) {
    if (!done) log_.add(std::move(done).error());
    return done.has_value();
  }

  Expected<void> prepare() {
    PANELCAL_TRY(machine_, read_machine_config(options_.machine));
    const std::chrono::sys_seconds now = system_clock()();
    PANELCAL_TRY(const std::string time, wall_time(options_.clock, now, kCommand));
    if (options_.turned_deg) machine_.walk.base_limits.turned_deg = *options_.turned_deg;
    PANELCAL_TRY(const std::optional<ExplainChoice> explain, explain_choice(options_));
    std::optional<OutputFormat> format;
    if (!options_.output.empty()) {
      PANELCAL_TRY(format, output_format(options_));
    }
    if (options_.resolution_um && !(format && is_program(*format))) {
      return failure(usage("--resolution without a program to write",
                           "-o with .drl, .exc, .s5 or .sm, or --to excellon or sieb-meyer"));
    }
    if (!options_.flavour.empty()) {
      if (format != OutputFormat::Gcode) {
        return failure(usage("--flavour without G-code to write", "-o with .ngc, or --to gcode"));
      }
      if (machine_.gcode) machine_.gcode->flavour = gcode_flavour_from_name(options_.flavour);
    }
    std::optional<Truth> truth;
    if (!options_.truth.empty()) {
      PANELCAL_TRY(truth, read_truth_json(options_.truth));
    }
    std::shared_ptr<const ZonedMap> surface;
    std::optional<int> surface_axis;
    if (!options_.surface.empty()) {
      PANELCAL_TRY(StoredZones stored, read_zoned_map_file(options_.surface));
      surface = std::make_shared<const ZonedMap>(std::move(stored.map));
      surface_axis = stored.z_axis;
    }
    std::shared_ptr<const Survey> aligned;
    if (!options_.align.empty()) {
      PANELCAL_TRY(aligned, read_aligned(now));
    }
    machine_.reading.take(options_.reading);
    PANELCAL_TRY(job_, read_job(options_.program, machine_, now));
    PANELCAL_CHECK(check_patterns(context_.options, job_.program, context_.files));
    job_.clock = options_.clock;
    job_.format = format;
    job_.explain = explain;
    job_.command = kCommand;
    job_.surface = std::move(surface);
    job_.surface_axis = surface_axis;
    job_.aligned = std::move(aligned);
    job_.truth = std::move(truth);
    if (!options_.slots.empty()) job_.keeps_slots = options_.slots == "keep";
    if (options_.resolution_um) job_.resolution = um(*options_.resolution_um);
    job_.force = options_.force;
    job_.compares_models = job_.finds_worst_place = job_.keeps_places = options_.facts.any();
    job_.max_operations = options_.max_operations;
    note_provenance(time);
    if (options_.output == "-") {
      output_ = std::make_unique<SpooledOutput>(context_.output);
    } else if (!options_.output.empty()) {
      output_ = std::make_unique<FileOutput>(options_.output);
    }
    return {};
  }

  Expected<std::shared_ptr<const Survey>> read_aligned(std::chrono::sys_seconds now) {
    PANELCAL_TRY(const Alignment alignment, read_alignment(options_.align));
    PANELCAL_CHECK(check_age(alignment, now, hours(options_.valid_hours)));
    PANELCAL_TRY(const AlignedPanel panel, restore_panel(alignment, machine_, now));
    aligned_words_ = fmt::format("the alignment {} of {}, seen {}: {}",
                                 options_.align,
                                 iso_8601(alignment.time),
                                 iso_8601(alignment.last_seen()),
                                 alignment.source);
    return panel.survey();
  }

  /// The digest of a large program takes as long as reading it, so it is made where it is told.
  void note_provenance(const std::string& time) {
    const bool is_told = options_.facts.any() || (job_.format && has_comments(*job_.format));
    if (!is_told) return;
    provenance_ = provenance_of(context_.options,
                                job_.program,
                                {options_.machine,
                                 machine_.spindle_setting.file.string(),
                                 machine_.table_file.string(),
                                 options_.measurements,
                                 options_.align,
                                 options_.probes,
                                 options_.surface});
    const bool drifts = machine_.drift_um_per_sqrt_day > 0;
    if (drills_the_time(job_.program) || drifts) provenance_.emplace_back("clock", time);
    job_.comments = comment_lines(provenance_);
  }

  SourceChoice source_choice() {
    return {.command = kCommand,
            .images = options_.images,
            .measurements = options_.measurements,
            .camera = options_.camera,
            .machine_driver = options_.machine_driver,
            .probes = options_.probes,
            .uncorrected = options_.uncorrected,
            .observer = observer(),
            .executor = pool_.get(),
            .prompt = [this] { return operator_prompt(kCommand, context_.console); },
            .taken_by = {
                system_clock(), asking_person(""), std::string("panelcal ") + kVersion, [this] {
                  return check_noted_heads(machine_);
                }}};
  }

  /// Sizes are for the explanation of a refusal, pictures for the report.
  PictureObserver observer() {
    PictureObserver draw = options_.facts.any() ? pictures_.observer() : PictureObserver();
    return [this, draw](const SeenView& seen) {
      scale_.add(seen.detection);
      if (draw) draw(seen);
    };
  }

  void explain_refused_fits(const Survey& survey) {
    if (!log_.has_errors()) return;
    if (const auto words = camera_pose_words(survey)) context_.console.say(*words);
  }

  void end_progress(std::string_view remark) {
    context_.console.end_progress();
    if (!remark.empty()) context_.console.say(remark);
  }

  Expected<void> tell_measured(const Survey& survey) {
    if (job_.aligned) context_.console.say("the panel is known by " + aligned_words_);
    context_.console.say(fits_summary(survey));
    if (!options_.save_measurements.empty()) {
      PANELCAL_CHECK(
          context_.output.write_to(options_.save_measurements, measurement_lines(survey)));
    }
    if (options_.save_probes.empty()) return {};
    std::string lines;
    for (const ProbeReading& reading : survey.probes) lines += to_json(reading) + "\n";
    return context_.output.write_to(options_.save_probes, lines);
  }

  static std::string gates_off_words(const JobResult& result) {
    const std::vector<std::string> off = result.survey->gates_off();
    return off.empty() ? "" : fmt::format("; gates off: {}", fmt::join(off, ", "));
  }

  /// Of the verdict: a camera whose scale is wrong moves holes without any target that is off.
  std::string scale_words() {
    const auto words = scale_.words();
    return words ? "; " + *words : "";
  }

  /// Once, in the report's messages too.
  void warn_of_scale() {
    auto warning = scale_.warning(options_.machine);
    if (warning && !std::exchange(has_warned_of_scale_, true)) log_.add(*std::move(warning));
  }

  void tell(const JobResult& result) {
    Console& console = context_.console;
    if (!result.explanation.empty()) {
      // With a result on standard output the explanation must not mix with it.
      if (options_.output == "-" || options_.facts.json == "-") {
        console.say(result.explanation);
      } else {
        take(context_.output.write(result.explanation));
      }
    }
    if (result.is_judged && result.verdict) {
      console.say(verdict_summary(*result.verdict, result.truth.get()) + gates_off_words(result) +
                  scale_words());
    }
    if (result.is_judged && result.depth) console.say(depth_summary(*result.depth));
    if (!is_written_) return;
    const Tally& tally = result.tally;
    console.say(fmt::format(
        "{} written to {}, largest shift {:.1f} um, largest predicted sigma {:.3f} um{}",
        amount(tally),
        options_.output == "-" ? "standard output" : options_.output,
        tally.max_shift().in_um(),
        tally.max_sigma().in_um(),
        tally.max_sigma() > Length() && !result.unstated.empty()
            ? " (of the fit only: " + result.unstated + ")"
            : ""));
    if (result.surface_use) console.say(result.surface_use->summary());
    if (result.truth) console.say("\nerror against truth\n" + result.truth->summary());
  }

  JobFactsInput all_facts_of(const JobResult& result) {
    JobFactsInput input = facts_input(result);
    input.program_file = job_.program.source.file;
    input.machine_name = machine_.name;
    input.output_file = is_written_ ? options_.output : "";
    input.forced = is_written_ && log_.has_errors();
    input.common_scale = scale_.words().value_or("");
    input.pictures = std::move(pictures_.by_seq);
    input.diagnostics = log_.kept();
    input.provenance = provenance_;
    input.provenance.emplace_back(
        "date", options_.clock.empty() ? iso_8601(system_clock()()) : options_.clock);
    std::ranges::move(ledger_head_row(machine_.ledger_file), std::back_inserter(input.provenance));
    return input;
  }

  void state(const JobResult& result) {
    if (!options_.facts.any()) return;
    warn_of_scale();
    const JobFactsInput input = all_facts_of(result);
    stated_ = state_facts(
                  context_,
                  options_.facts,
                  input.program_file + " - panelcal",
                  [&] { return job_facts(input); },
                  {},
                  job_pictures(input))
                  .code;
    if (stated_ == ExitCode::Done && !options_.facts.report.empty()) {
      context_.console.say("report: " + options_.facts.report);
    }
  }

  ExitCode finish() {
    warn_of_scale();
    context_.console.print(log_);
    if (log_.has_errors() && !is_written_ && !options_.output.empty()) {
      const auto* const spooled = dynamic_cast<const SpooledOutput*>(output_.get());
      context_.console.say(spooled != nullptr && spooled->has_begun_to_commit()
                               ? "standard output is not to be used"
                           : options_.output == "-" ? "nothing was written to standard output"
                                                    : "nothing was written to " + options_.output);
    }
    return std::max(exit_code(log_), stated_);
  }

  const RunOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
  MachineConfig machine_;
  Job job_;
  std::string aligned_words_;  ///< the origin of Job::aligned
  Provenance provenance_;
  SeenPictures pictures_;
  CommonScale scale_;
  bool has_warned_of_scale_ = false;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<JobOutput> output_;
  bool is_written_ = false;
  ExitCode stated_ = ExitCode::Done;  ///< of the facts
};

}  // namespace

Expected<Answer> run_command(const RunOptions& options, CommandContext& context) {
  return Answer{{}, RunCommand(options, context).run()};
}

}  // namespace panelcal
