// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/atomic_file.h"
#include "calib/base/clock.h"
#include "machine/config/machine_config.h"
#include "machine/sim/truth.h"
#include "program/judge/depth_errors.h"
#include "program/judge/depth_verdict.h"
#include "program/judge/explain.h"
#include "program/judge/job_check.h"
#include "program/judge/job_verdict.h"
#include "program/judge/probed_surface.h"
#include "program/judge/surface_use.h"
#include "program/writers/csv_writer.h"
#include "program/writers/excellon_writer.h"
#include "program/writers/gcode_writer.h"
#include "program/writers/jsonl_writer.h"
#include "program/writers/sieb_meyer_writer.h"
#include "program/writers/svg_writer.h"
#include "surface/map/file.h"
#include "tools/cli/commands.h"
#include "tools/cli/measuring.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/program_input.h"
#include "tools/cli/provenance.h"
#include "tools/cli/text_variables.h"
#include "tools/report/budget.h"
#include "tools/report/html.h"
#include "tools/run/depth_summary.h"
#include "tools/run/job_picture.h"
#include "tools/run/spindle_age.h"
#include "tools/run/truth_comparison.h"
#include "tools/run/verdict_summary.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

Expected<std::string> output_format(const RunOptions& options) {
  if (!options.format.empty()) return options.format;
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kByExtension = {
      {{".jsonl", "jsonl"},
       {".csv", "csv"},
       {".drl", "excellon"},
       {".exc", "excellon"},
       {".s5", "sieb-meyer"},
       {".sm", "sieb-meyer"},
       {".ngc", "gcode"},
       {".svg", "svg"}}};
  const std::string extension = extension_of(options.output);
  for (const auto& [known, format] : kByExtension) {
    if (extension == known) return std::string(format);
  }
  return failure({Code::Usage,
                  {"panelcal run", 0, 0},
                  "no format belongs to the output's name " + quoted(options.output),
                  ".jsonl, .csv, .drl, .exc, .s5, .sm, .ngc or .svg, or --to"});
}

/// One run, stage by stage. Every stage leaves its problems in log_.
class Run {
 public:
  Run(const RunOptions& options, CommandContext& context) : options_(options), context_(context) {}

  ExitCode execute_all() {
    if (!prepare() || !measure()) return finish();
    const bool may_write = !log_.has_errors() || (options_.force && has_only_gate_failures());
    const bool is_complete = measured_.survey.is_complete() && knows_surfaces();
    if (is_complete) explain();
    if (may_write && is_complete && !options_.output.empty()) write_program();
    write_report();
    return finish();
  }

 private:
  template <class T>
  bool take(Expected<T> value, T& out) {
    if (value) {
      out = *std::move(value);
      return true;
    }
    log_.add(std::move(value).error());
    return false;
  }
  bool take(Expected<void> done) {
    if (!done) log_.add(std::move(done).error());
    return done.has_value();
  }

  bool prepare() {
    if (!take(read_machine_config(options_.machine), config_)) return false;
    config_.walk.max_operations = options_.max_operations;
    config_.walk.compares_models = !options_.report.empty();
    const std::chrono::sys_seconds now = system_clock()();
    std::string time;
    if (!take(wall_time(options_.clock, now), time)) return false;
    if (!take(age_offset(config_, options_.clock, now))) return false;
    set_text_variables(options_.program, time, config_.walk.sieb_meyer.text);
    if (!take(read_choice())) return false;
    if (!options_.output.empty() && !take(output_format(options_), format_)) return false;
    if (!take(check_gcode())) return false;
    if (!take(check_output_paths("panelcal run",
                                 {options_.program,
                                  options_.machine,
                                  options_.measurements,
                                  options_.probes,
                                  options_.surface,
                                  options_.truth},
                                 {options_.output,
                                  options_.save_measurements,
                                  options_.save_probes,
                                  options_.report}))) {
      return false;
    }
    const bool is_program = format_ == "excellon" || format_ == "sieb-meyer";
    const bool keeps =
        options_.slots.empty() ? is_program || format_ == "svg" : options_.slots == "keep";
    config_.walk.slots = keeps ? Cycles::Kept : Cycles::Expanded;
    // No plain block gives the depth of a single pass, so programs keep G87 in any case.
    config_.walk.step_slots = keeps || is_program ? Cycles::Kept : Cycles::Expanded;
    if (!options_.truth.empty()) {
      Truth truth;
      if (!take(read_truth_json(options_.truth), truth)) return false;
      truth_ = std::move(truth);
    }
    if (!options_.surface.empty() && !take(read_surface_map())) return false;
    checked_ = read_and_check(options_.program, config_.reading, config_.walk, log_);
    if (log_.has_errors() || !checked_ || !knows_depths()) return false;
    const bool measures = !checked_->nominal_survey.measurements.empty();
    if (measures && !take(check_spindle_is_calibrated(config_))) return false;
    provenance_ = provenance_of(context_.options,
                                checked_->program,
                                {options_.machine,
                                 config_.spindle_setting.file.string(),
                                 config_.table_file.string(),
                                 options_.measurements,
                                 options_.probes,
                                 options_.surface});
    const bool drifts = config_.drift_um_per_sqrt_day > 0;
    if (drills_the_time(checked_->program) || drifts) provenance_.emplace_back("clock", time);
    return true;
  }

  /// Heights belong to nominal places, so whether all depths have one shows before anything is
  /// measured.
  bool knows_depths() {
    const BoardDepths& board = config_.walk.board;
    if (board.map == nullptr && board.tools.empty()) return true;
    SurfaceUse ignored;
    execute_nominal(*checked_, config_.walk, ignored, log_);
    return !log_.has_errors();
  }

  Expected<void> read_surface_map() {
    PANELCAL_TRY(StoredZones stored, read_zoned_map_file(options_.surface));
    config_.walk.board.map = std::make_shared<const ZonedMap>(std::move(stored.map));
    return {};
  }

  /// How wrong depths may be, by a map that was given, or by what the job's probes show.
  const DepthErrors& depth_errors() {
    if (!depth_errors_) {
      const BoardDepths& board = config_.walk.board;
      std::vector<Expected<ZonedMap>> maps;
      if (board.map != nullptr) {
        maps.emplace_back(*board.map);
      } else {
        maps = probed_surfaces(measured_.survey, config_.walk.sieb_meyer.grid_hold);
      }
      depth_errors_.emplace(config_.walk.uncertainty.depth, std::move(maps), format_ != "gcode");
    }
    return *depth_errors_;
  }

  /// Empty if nothing is asked of depths.
  std::optional<DepthJudge> depth_judge() {
    const Tolerances& tolerances = config_.walk.tolerances;
    if (!tolerances.asks_depths()) return std::nullopt;
    return DepthJudge(tolerances, depth_errors());
  }

  /// False if there is nothing to go on with; targets that were lost are something.
  bool measure() {
    DiagnosticLog found;
    const bool has_source = take(measure_program(options_,
                                                 config_,
                                                 checked_->program,
                                                 checked_->nominal_survey,
                                                 context_.console,
                                                 found),
                                 measured_);
    // The warnings are those of the check, said already.
    for (const Diagnostic& diagnostic : found.kept()) {
      const bool is_new = diagnostic.severity() == Severity::Error ||
                          diagnostic.code == Code::TargetDropped || is_unsaid(diagnostic);
      if (is_new) log_.add(diagnostic);
    }
    if (!has_source || (exit_code(found) > ExitCode::GateFailed)) return false;
    if (config_.walk.board.map != nullptr) {
      hold_against_map(
          measured_.survey, *config_.walk.board.map, checked_->program.source.file, log_);
    }
    context_.console.say(fits_summary(measured_.survey));
    return save_measurements() && save(options_.save_probes, measured_.survey.probes);
  }

  /// To be replayed.
  bool save_measurements() {
    if (options_.save_measurements.empty()) return true;
    return take(write_result(options_.save_measurements, measurement_lines(measured_.survey)));
  }

  /// Only the measurement source knows that it does not calibrate, and where a probe found nothing.
  bool is_unsaid(const Diagnostic& diagnostic) const {
    const bool is_of_measuring =
        diagnostic.code == Code::CalibrationNotPerformed || diagnostic.code == Code::GridFilled;
    return is_of_measuring && std::ranges::none_of(log_.kept(), [&](const Diagnostic& said) {
             return said.text() == diagnostic.text();
           });
  }

  /// Probe readings, to be replayed.
  template <class T>
  bool save(const std::string& path, const std::vector<T>& answers) {
    if (path.empty()) return true;
    std::string lines;
    for (const T& answer : answers) lines += to_json(answer) + "\n";
    return take(write_result(path, lines));
  }

  /// To a file, whole or not at all, or to standard output.
  Expected<void> write_result(const std::string& path, std::string_view bytes) {
    return path == "-" ? context_.output.write(bytes) : write_file(path, bytes);
  }

  /// What --explain asks for; without it there has to be an output.
  Expected<void> read_choice() {
    if (!options_.explain.empty()) {
      choice_ = parse_explain_choice(options_.explain);
      if (choice_ && options_.output.empty() && !options_.report.empty()) {
        return failure({Code::Usage,
                        {"panelcal run", 0, 0},
                        "--report without an output",
                        "-o OUTPUT as well"});
      }
      if (choice_) return {};
      return failure({Code::Usage,
                      {"panelcal run", 0, 0},
                      "--explain " + quoted(options_.explain),
                      "L and a line, such as L14, or the number of a place from 1"});
    }
    if (!options_.output.empty()) return {};
    return failure({Code::Usage,
                    {"panelcal run", 0, 0},
                    "there is nothing to write",
                    "-o OUTPUT, or --explain"});
  }

  Expected<void> check_gcode() const {
    if (format_ != "gcode" || config_.gcode) return {};
    return failure({Code::ConfigValue,
                    {options_.machine, 0, 0},
                    "[gcode] is missing, which states how high and how deep tools go in G-code",
                    "[gcode] with safe_z_mm, drill_z_mm and others (docs/formats/gcode.md)"});
  }

  /// As places are counted for --explain: numbers must not depend on the output's format.
  WalkOptions counting_walk() const {
    WalkOptions walk = config_.walk;
    walk.slots = walk.step_slots = Cycles::Expanded;
    return walk;
  }

  bool has_tolerances() const {
    return config_.walk.tolerances.asks_positions() || config_.walk.tolerances.asks_depths();
  }

  /// What holds a job against [tolerance] as it passes.
  std::vector<OperationSink*> make_verdicts() {
    const Tolerances& tolerances = config_.walk.tolerances;
    std::vector<OperationSink*> sinks;
    if (tolerances.asks_positions()) sinks.push_back(&verdict_.emplace(tolerances));
    if (tolerances.asks_depths()) {
      sinks.push_back(&depth_.emplace(tolerances, depth_errors()));
    }
    return sinks;
  }

  /// Without an output this is the walk that the job is judged by.
  void explain() {
    if (!choice_) return;
    const WalkOptions walk = counting_walk();
    Explainer explainer(*choice_,
                        checked_->program,
                        measured_.survey,
                        walk.uncertainty,
                        walk.tolerances,
                        depth_judge());
    std::vector<OperationSink*> sinks = {&explainer};
    const bool judges = options_.output.empty() && has_tolerances();
    if (judges) std::ranges::copy(make_verdicts(), std::back_inserter(sinks));
    Tee tee(std::move(sinks));
    DiagnosticLog walk_log;
    execute(checked_->program, walk, measured_.survey, tee, walk_log);
    for (const Diagnostic& diagnostic : walk_log.kept()) log_.add(diagnostic);
    if (!explainer.has_found() && choice_->number) {
      log_.add({Code::Usage, {"panelcal run", 0, 0}, "--explain: " + explainer.text(), ""});
      return;
    }
    // With a result on standard output the explanation must not mix with it.
    if (options_.output == "-") {
      context_.console.say(explainer.text());
    } else {
      take(context_.output.write(explainer.text()));
    }
    if (judges && !walk_log.has_errors()) is_sure_enough();
  }

  /// A walk stops at a surface that was not found or that is out of tolerance, and --force knows no
  /// other depth.
  bool knows_surfaces() const {
    return std::ranges::none_of(log_.kept(), [](const Diagnostic& diagnostic) {
      return diagnostic.code == Code::SurfaceNotFound ||
             diagnostic.code == Code::SurfaceOutOfTolerance;
    });
  }

  bool has_only_gate_failures() const { return exit_code(log_) == ExitCode::GateFailed; }

  std::unique_ptr<TextWriter> make_writer(ByteSink& bytes) {
    if (format_ == "jsonl") return std::make_unique<JsonlWriter>(bytes, depth_judge());
    if (format_ == "csv") return std::make_unique<CsvWriter>(bytes, depth_judge());
    if (format_ == "svg") return std::make_unique<SvgWriter>(bytes, scene());
    return make_program_writer(bytes);
  }

  std::unique_ptr<ProgramWriter> make_program_writer(ByteSink& bytes) const {
    const ProgramWriterOptions writing{.comments = comment_lines(provenance_),
                                       .allow_losses = true,  // all of them are to be named
                                       .absolute_zero = config_.walk.absolute_zero,
                                       .work_zero = config_.walk.work_zero};
    if (format_ == "sieb-meyer") return std::make_unique<SiebMeyerWriter>(bytes, writing);
    if (format_ == "gcode") return std::make_unique<GcodeWriter>(bytes, writing, *config_.gcode);
    return std::make_unique<ExcellonWriter>(bytes, writing);
  }

  /// A picture has to know how large it is before its first hole, so the job passes once more.
  SvgScene scene() const {
    Tally tally;
    DiagnosticLog ignored;
    execute(checked_->program, config_.walk, measured_.survey, tally, ignored);
    SvgScene scene = svg_scene(tally);
    scene.targets = picture_targets(measured_.survey);
    scene.title = checked_->program.source.file;
    scene.provenance = comment_lines(provenance_);
    return scene;
  }

  /// What judges the job as it passes.
  std::vector<OperationSink*> judges() {
    std::vector<OperationSink*> sinks = {&worst_hole_};
    std::ranges::copy(make_verdicts(), std::back_inserter(sinks));
    if (truth_) {
      sinks.push_back(&comparison_.emplace(*truth_, measured_.survey, config_.walk.uncertainty));
    }
    return sinks;
  }

  /// What has gone to standard output cannot be taken back, so the job passes once more before it:
  /// false if it is not to be drilled.
  bool judge_first() {
    Tee tee(judges());
    DiagnosticLog walk_log;
    execute(checked_->program, config_.walk, measured_.survey, tee, walk_log);
    // Otherwise the writing walk says the same again.
    if (!walk_log.has_errors()) return is_sure_enough();
    for (const Diagnostic& diagnostic : walk_log.kept()) log_.add(diagnostic);
    return false;
  }

  void write_program() {
    const bool is_judged = options_.output == "-" && has_tolerances();
    if (is_judged && !judge_first()) return;
    std::optional<AtomicFile> file;
    ByteSink* bytes = &context_.output;
    if (options_.output != "-") {
      Expected<AtomicFile> created = AtomicFile::create(options_.output);
      if (!created) return log_.add(std::move(created).error());
      file.emplace(*std::move(created));
      bytes = &*file;
    }
    const auto writer = make_writer(*bytes);
    JobCheck job_check(config_.travel);
    std::vector<OperationSink*> sinks = {writer.get(), &tally_, &job_check};
    if (config_.walk.board.map != nullptr) sinks.push_back(&surface_use_.emplace());
    if (!is_judged) std::ranges::copy(judges(), std::back_inserter(sinks));
    Tee tee(std::move(sinks));
    DiagnosticLog walk_log;
    has_begun_ = true;
    execute(checked_->program, config_.walk, measured_.survey, tee, walk_log);
    job_check.report(checked_->program, walk_log);
    if (const auto* program = dynamic_cast<const ProgramWriter*>(writer.get())) {
      for (const Diagnostic& loss : program->losses().kept()) walk_log.add(loss);
    }
    for (const Diagnostic& diagnostic : walk_log.kept()) log_.add(diagnostic);
    if (walk_log.has_errors() || (!is_judged && !is_sure_enough())) return;
    if (!take(writer->finish()) || (file && !take(file->commit()))) return;
    is_written_ = true;
    context_.console.say(
        fmt::format("{} written to {}, largest shift {:.1f} um, largest predicted sigma {:.3f} um",
                    amount(tally_),
                    options_.output == "-" ? "standard output" : options_.output,
                    tally_.max_shift().in_um(),
                    tally_.max_sigma().in_um()));
    if (surface_use_) context_.console.say(surface_use_->summary());
    if (comparison_) context_.console.say("\nerror against truth\n" + comparison_->summary());
  }

  /// What [tolerance] makes of the job that has just passed: false if it is not to be drilled.
  bool is_sure_enough() {
    bool is_held = false;
    if (verdict_) {
      context_.console.say(verdict_summary(*verdict_, comparison_ ? &*comparison_ : nullptr));
      verdict_->report(checked_->program.source.file, log_);
      is_held = verdict_->decision() == JobDecision::Hold;
    }
    if (depth_) {
      context_.console.say(depth_summary(*depth_));
      depth_->report(checked_->program.source.file, log_);
      is_held = is_held || depth_->decision() == JobDecision::Hold;
    }
    return !is_held || options_.force;
  }

  /// Of the worst place that a warning names, where its line does not lead to it: lines of other
  /// files cannot be asked for, of a line that is repeated only the first places are told, and one
  /// that lowers the tool has no place.
  std::optional<std::int64_t> worst_number() const {
    const JobVerdict::ToolFigures* const tool = verdict_ ? verdict_->worst_tool() : nullptr;
    if (tool == nullptr || verdict_->decision() != JobDecision::DrillWithWarning) return {};
    PlaceNumber finder(tool->worst);
    DiagnosticLog ignored;
    execute(checked_->program, counting_walk(), measured_.survey, finder, ignored);
    const bool is_enough =
        tool->worst.file.empty() && tool->worst.path.empty() && finder.is_of_its_line();
    return is_enough ? std::nullopt : finder.number();
  }

  void write_report() {
    if (options_.report.empty()) return;
    ReportInput input;
    input.program_file = checked_->program.source.file;
    input.machine_name = config_.name;
    input.source = measured_.source;
    input.output_file = is_written_ ? options_.output : "";
    input.forced = is_written_ && log_.has_errors();
    input.survey = &measured_.survey;
    input.tally = is_written_ ? &tally_ : nullptr;
    input.truth = is_written_ && comparison_ ? &*comparison_ : nullptr;
    input.verdict = verdict_ ? &*verdict_ : nullptr;
    input.depth = depth_ ? &*depth_ : nullptr;
    // Of a job that is held it is all the more wanted.
    if (verdict_) {
      input.worst_hole = likeliest_to_break(*verdict_, measured_.survey, config_.walk.uncertainty);
    }
    if (!input.worst_hole) {
      input.worst_hole = worst_hole_.budget(measured_.survey, config_.walk.uncertainty);
    }
    if (surface_use_) input.surface_use = surface_use_->summary();
    input.worst_number = worst_number();
    input.crops_png = std::move(measured_.crops_png);
    input.views = std::move(measured_.views);
    input.diagnostics = log_.kept();
    input.provenance = provenance_;
    input.provenance.emplace_back("date", iso_8601(system_clock()()));
    if (take(write_result(options_.report, report_html(input)))) {
      context_.console.say("report: " + options_.report);
    }
  }

  ExitCode finish() {
    context_.console.print(log_);
    if (log_.has_errors() && !is_written_ && !options_.output.empty()) {
      const bool is_streamed = options_.output == "-";
      context_.console.say(is_streamed && has_begun_ ? "standard output is not to be used"
                           : is_streamed             ? "nothing was written to standard output"
                                                     : "nothing was written to " + options_.output);
    }
    return exit_code(log_);
  }

  const RunOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
  MachineConfig config_;
  std::string format_;
  std::optional<ExplainChoice> choice_;
  std::optional<Truth> truth_;
  std::optional<TruthComparison> comparison_;
  std::optional<CheckedProgram> checked_;
  Provenance provenance_;
  MeasuringResult measured_;
  Tally tally_;
  WorstHole worst_hole_;
  std::optional<JobVerdict> verdict_;
  std::optional<DepthErrors> depth_errors_;
  std::optional<DepthVerdict> depth_;
  std::optional<SurfaceUse> surface_use_;
  bool has_begun_ = false;  ///< something may have gone to the output
  bool is_written_ = false;
};

}  // namespace

ExitCode run_command(const RunOptions& options, CommandContext& context) {
  return Run(options, context).execute_all();
}

}  // namespace panelcal
