// SPDX-License-Identifier: Apache-2.0
#include "machine/job/job.h"

#include <algorithm>
#include <ranges>
#include <utility>

#include "machine/job/alignment_check.h"
#include "machine/job/checked_program.h"
#include "machine/job/execution.h"
#include "machine/job/walk_terms.h"
#include "program/walk/measuring/pad_collector.h"
#include "program/walk/walk.h"
#include "program/writers/output_digits.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::JobExecution;

using Progress = std::function<void(std::string_view)>;

/// Tells how far the measuring is.
class ProgressTargets final : public MeasurementSource {
 public:
  ProgressTargets(MeasurementSource& source, std::size_t n_targets, const Progress& progress)
      : source_(source), n_targets_(n_targets), progress_(progress) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    progress_(fmt::format("measuring target {} of {} ({}, line {})",
                          request.seq + 1,
                          n_targets_,
                          request.command,
                          request.line));
    Expected<Measurement> measurement = source_.measure(request);
    if (measurement) answers_.push_back(*measurement);
    return measurement;
  }
  bool reconsiders() const override { return source_.reconsiders(); }
  Expected<std::optional<Measurement>> reconsider(const Contradiction& contradiction) override {
    PANELCAL_TRY(const std::optional<Measurement> anew, source_.reconsider(contradiction));
    if (anew) answers_[static_cast<std::size_t>(anew->request.seq)] = *anew;
    return anew;
  }
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    progress_(fmt::format("focusing ({}, line {})", request.command, request.line));
    return source_.focus(request);
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    progress_(fmt::format("calibrating ({}, line {})", order.command, order.line));
    return source_.calibrate(order);
  }

  DrilledPanel* drilled_panel() override { return source_.drilled_panel(); }

  /// In the order of the requests.
  const std::vector<Measurement>& answers() const { return answers_; }

 private:
  MeasurementSource& source_;
  std::size_t n_targets_;
  const Progress& progress_;
  std::vector<Measurement> answers_;
};

/// Answers what was asked before as it was answered then, and everything else as a perfect panel
/// does; keeps the requests that are new.
class ForecastTargets final : public MeasurementSource {
 public:
  explicit ForecastTargets(const std::vector<Measurement>& answers) : answers_(answers) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    if (n_asked_ < answers_.size()) return answers_[n_asked_++];
    requests_.push_back(request);
    return panel_.measure(request);
  }
  std::vector<MeasurementRequest> take() { return std::move(requests_); }

 private:
  const std::vector<Measurement>& answers_;
  std::size_t n_asked_ = 0;
  std::vector<MeasurementRequest> requests_;
  NominalSource panel_;
};

class ProgressProbes final : public ProbeSource {
 public:
  ProgressProbes(ProbeSource& source, std::size_t n_probes, const Progress& progress)
      : source_(source), n_probes_(n_probes), progress_(progress) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    progress_(fmt::format("probing place {} of {} ({}, line {})",
                          request.seq + 1,
                          n_probes_,
                          request.command,
                          request.line));
    return source_.probe(request);
  }

 private:
  ProbeSource& source_;
  std::size_t n_probes_;
  const Progress& progress_;
};

class NoSink final : public OperationSink {
 public:
  void put(const Operation&) override {}
};

bool is_gate_failure(const Diagnostic& diagnostic) {
  return info(diagnostic.code).fault == Fault::Gate;
}

/// True if all errors, if there are any, are limits that were not held.
bool has_only_gate_failures(const DiagnosticLog& log) {
  return std::ranges::all_of(log.kept(), [](const Diagnostic& diagnostic) {
    return diagnostic.severity() != Severity::Error || is_gate_failure(diagnostic);
  });
}

/// One job, stage by stage. Every stage leaves its problems in the result's log.
class JobRun {
 public:
  JobRun(const Job& job,
         const OpenJobSources& open,
         const MachineConfig& machine,
         const JobSinks& sinks)
      : job_(job),
        open_(open),
        machine_(machine),
        sinks_(sinks),
        survey_(job.aligned ? std::make_shared<Survey>(*job.aligned) : std::make_shared<Survey>()) {
    result_.log = job.reading;
  }

  Expected<JobResult> run() {
    const bool is_measured = prepare() && check_program() && measure();
    if (is_measured) {
      execute_job();
      find_worst_number();
    }
    if (sinks_.log != nullptr) *sinks_.log = result_.log;
    result_.survey = survey_;
    if (is_measured) return std::move(result_);
    return failure(result_.refusal());
  }

 private:
  bool take(Expected<void> done) {
    if (!done) result_.log.add(std::move(done).error());
    return done.has_value();
  }
  template <class T>
  bool take(Expected<T> value, T& out) {
    if (value) {
      out = *std::move(value);
      return true;
    }
    result_.log.add(std::move(value).error());
    return false;
  }

  /// A format without a place for it, or the reverse, would write nothing and be silent.
  Expected<void> check_output() const {
    if (job_.format.has_value() == (sinks_.output != nullptr)) return {};
    return failure({Code::Usage,
                    {job_.command, 0, 0},
                    job_.format ? "Job::format without JobSinks::output"
                                : "JobSinks::output without Job::format",
                    "both, or neither"});
  }

  bool prepare() {
    WalkOptions& walk = machine_.walk;
    walk.compares_models = job_.compares_models;
    walk.aligned = job_.aligned;
    const std::string& file = job_.program.source.file;
    const WalkTerms terms = {.program = file == kStandardInput ? "-" : file,
                             .clock = job_.clock,
                             .now = job_.now,
                             .max_operations = job_.max_operations,
                             .command = job_.command};
    std::string time;
    if (!take(set_walk_terms(terms, machine_), time) || !take(check_output())) return false;
    if (job_.format && !take(check_output_format(*job_.format, machine_))) return false;
    const bool writes_program = job_.format && is_program(*job_.format);
    const bool keeps =
        job_.keeps_slots.value_or(writes_program || job_.format == OutputFormat::Svg);
    walk.slots = keeps ? Cycles::Kept : Cycles::Expanded;
    // No plain block gives the depth of a single pass, so programs keep G87 in any case.
    walk.step_slots = keeps || writes_program ? Cycles::Kept : Cycles::Expanded;
    if (writes_program) walk.uncertainty.output_rounding = written_digits().rounding();
    if (job_.surface != nullptr) walk.board.map = job_.surface;
    return take(check_surface_axis());
  }

  /// Z axis 0 of probes is that of spindle 1. A board is not as high under each spindle, so that a
  /// map of another one moves all depths by the difference. The spindle that drills is [spindle]
  /// number, else [program] spindle.
  Expected<void> check_surface_axis() const {
    const int number = machine_.spindle_setting.spindle;
    const int spindle = number != 1 ? number : machine_.walk.sieb_meyer.text.spindle;
    if (!job_.surface_axis || *job_.surface_axis + 1 == spindle) return {};
    return failure({Code::ConfigValue,
                    {machine_.file.string(), 0, 0},
                    fmt::format("surface map of Z axis {}, spindle {}, and spindle {} drills",
                                *job_.surface_axis,
                                *job_.surface_axis + 1,
                                spindle),
                    fmt::format("--surface with a map of --zaxis {}, or [spindle] number = {}",
                                spindle - 1,
                                *job_.surface_axis + 1)});
  }

  /// Precondition: the output is a program.
  OutputDigits written_digits() const {
    const bool is_excellon = job_.format == OutputFormat::Excellon;
    return output_digits(is_excellon ? Dialect::Excellon : Dialect::SiebMeyer,
                         program_info(job_.program, machine_.walk),
                         job_.resolution);
  }

  bool writes_operations() const {
    return job_.format || sinks_.operations != nullptr || !job_.explain;
  }

  std::unique_ptr<JobExecution> make_execution(JobExecution::Aim aim) const {
    return std::make_unique<JobExecution>(job_, machine_, *survey_, sinks_, aim);
  }

  /// Heights belong to nominal places, so whether all depths have one shows before anything is
  /// measured.
  bool has_depths_to_know() const {
    const BoardDepths& board = machine_.walk.board;
    return board.map != nullptr || !board.tools.empty();
  }

  /// A job may turn out to be executed when it is checked, but what a sink of others has been given
  /// cannot be taken back. A walk for depths goes on where the program asks, with series of its
  /// own, and the comparison with the truth needs those of the job.
  bool may_execute_on_check() const {
    const bool compares_on_nominal = has_depths_to_know() && job_.truth.has_value();
    return sinks_.operations == nullptr && !compares_on_nominal;
  }

  bool check_program() {
    auto execution = make_execution(writes_operations() ? JobExecution::Aim::Operations
                                                        : JobExecution::Aim::Verdict);
    const bool executes = may_execute_on_check() && execution->open().has_value();
    NoSink no_sink;
    OperationSink* const sink = executes ? static_cast<OperationSink*>(execution.get()) : &no_sink;
    const Execution until = has_depths_to_know() ? Execution::OfNominal
                            : executes           ? Execution::UntilAsked
                                                 : Execution::None;
    ++result_.n_walks;
    checked_ = check(job_.program, execution->walk(), until, sink, result_.log);
    if (result_.log.has_errors() || !fits_alignment() || !knows_depths()) return false;
    // An output that cannot be written is known before anything is measured.
    if (!executes && sinks_.output != nullptr && !take(sinks_.output->begin())) return false;
    if (executes && checked_.is_executed && !checked_.asks) execution_ = std::move(execution);
    const bool measures = !checked_.survey.measurements.empty();
    return !measures || take(check_spindle_is_calibrated(machine_));
  }

  bool fits_alignment() {
    if (!job_.aligned) return true;
    ++result_.n_walks;
    return take(check_fits_alignment(job_.program, machine_.walk, checked_.survey));
  }

  bool knows_depths() {
    if (!has_depths_to_know()) return true;
    if (checked_.is_executed) {
      add(checked_.working_log);
    } else {
      NoSink ignored;
      ++result_.n_walks;
      execute(job_.program, machine_.walk, checked_.survey, ignored, result_.log);
    }
    return !result_.log.has_errors();
  }

  void add(const DiagnosticLog& log) {
    for (const Diagnostic& diagnostic : log.kept()) result_.log.add(diagnostic);
  }

  /// False if there is nothing to go on with; targets that were lost are something.
  bool measure() {
    DiagnosticLog found;
    const bool has_source = take(survey_program(found));
    // The warnings are those of the check, said already.
    for (const Diagnostic& diagnostic : found.kept()) {
      const bool is_new = diagnostic.severity() == Severity::Error ||
                          diagnostic.code == Code::TargetDropped || is_unsaid(diagnostic);
      if (is_new) result_.log.add(diagnostic);
    }
    if (!has_source || !has_only_gate_failures(found)) return false;
    if (machine_.walk.board.map != nullptr) {
      hold_against_map(*survey_, *machine_.walk.board.map, job_.program.source.file, result_.log);
    }
    return !sinks_.measured || take(sinks_.measured(*survey_));
  }

  /// Only a measuring walk knows that a calibration was not performed, and where a probe found
  /// nothing.
  bool is_unsaid(const Diagnostic& diagnostic) const {
    const bool is_of_measuring =
        diagnostic.code == Code::CalibrationNotPerformed || diagnostic.code == Code::GridFilled;
    return is_of_measuring && std::ranges::none_of(result_.log.kept(), [&](const Diagnostic& said) {
             return said.text() == diagnostic.text();
           });
  }

  /// What the program itself asks for.
  Survey asked() const {
    Survey own = checked_.survey;
    if (!job_.aligned) return own;
    own.measurements.clear();
    own.series.clear();
    return own;
  }

  Expected<void> survey_program(DiagnosticLog& found) {
    PANELCAL_TRY(const JobSources sources, open_(asked()));
    result_.source = sources.words;
    if (checked_.asks) {
      const Progress progress = sinks_.progress ? sinks_.progress : [](std::string_view) {};
      ProgressTargets targets(*sources.targets, checked_.survey.measurements.size(), progress);
      ProgressProbes probes(*sources.probes, checked_.survey.probes.size(), progress);
      sources.targets->foresee([this, &targets] { return forecast(targets.answers()); });
      ++result_.n_walks;
      *survey_ = survey(job_.program, measuring_walk(), checked_, targets, probes, found);
    }
    if (sinks_.end_progress) sinks_.end_progress(sources.remark ? sources.remark() : "");
    if (sources.risks) {
      for (Diagnostic& risk : sources.risks()) result_.log.add(std::move(risk));
    }
    if (found.has_errors()) return {};
    PANELCAL_CHECK(sources.targets->finish());
    return sources.probes->finish();
  }

  /// The requests that are still to come; see RequestForecast. But for the first ones, which the
  /// check knows, they take a walk through the program.
  std::vector<MeasurementRequest> forecast(const std::vector<Measurement>& answers) {
    const Survey& nominal = checked_.survey;
    if (answers.empty()) {
      std::vector<MeasurementRequest> requests;
      for (const Measurement& answer : nominal.measurements) requests.push_back(answer.request);
      return requests;
    }
    // Bytes of program that are walked through while one picture is looked at.
    constexpr std::size_t kBytesPerPicture = 200'000;
    const std::size_t n_left =
        nominal.measurements.size() - std::min(nominal.measurements.size(), answers.size());
    const bool is_worth_it = job_.program.source.bytes.size() < n_left * kBytesPerPicture;
    if (!is_worth_it || !nominal.calibrations.empty()) return {};
    ForecastTargets targets(answers);
    NominalProbeSource probes;
    DiagnosticLog ignored;
    ++result_.n_walks;
    survey(job_.program, machine_.walk, checked_, targets, probes, ignored);
    return targets.take();
  }

  WalkOptions measuring_walk() {
    WalkOptions walk = machine_.walk;
    walk.known_pads = [this, known = std::optional<KnownPads>()]() mutable {
      if (!known) known = collect_pads();
      return &*known;
    };
    const std::size_t n_series = checked_.survey.series.size();
    walk.base_limits = share_false_alarm(walk.base_limits, n_series);
    walk.nested_limits = share_false_alarm(walk.nested_limits, n_series);
    walk.fitted = sinks_.fitted;
    return walk;
  }

  /// Asked for only when a series does not fit.
  KnownPads collect_pads() {
    PadCollector collector(checked_.survey);
    DiagnosticLog said_already;
    ++result_.n_walks;
    execute(job_.program, machine_.walk, checked_.survey, collector, said_already);
    return collector.take();
  }

  /// A walk stops at a surface that was not found or that is out of tolerance, and Job::force knows
  /// no other depth.
  bool knows_surfaces() const {
    return std::ranges::none_of(result_.log.kept(), [](const Diagnostic& diagnostic) {
      return diagnostic.code == Code::SurfaceNotFound ||
             diagnostic.code == Code::SurfaceOutOfTolerance;
    });
  }

  void execute_job() {
    if (!survey_->is_complete() || !knows_surfaces()) return;
    const bool may_write =
        !result_.log.has_errors() || (job_.force && has_only_gate_failures(result_.log));
    if (writes_operations() && !may_write && !job_.explain) return;
    if (execution_ != nullptr && may_write) return finish(checked_.working_log);
    execution_ = make_execution(!writes_operations() ? JobExecution::Aim::Verdict
                                : may_write          ? JobExecution::Aim::Operations
                                                     : JobExecution::Aim::Explanation);
    if (!take(execution_->open())) return;
    DiagnosticLog working_log;
    ++result_.n_walks;
    execute(job_.program, execution_->walk(), *survey_, *execution_, working_log);
    finish(std::move(working_log));
  }

  void finish(DiagnosticLog working_log) {
    std::optional<Explainer> explainer;
    if (execution_->has_to_explain_anew()) {
      explainer.emplace(execution_->make_explainer());
      DiagnosticLog said_already;
      ++result_.n_walks;
      execute(job_.program, execution_->counting_walk(), *survey_, *explainer, said_already);
    }
    execution_->finish(std::move(working_log), explainer ? &*explainer : nullptr, result_);
  }

  /// Of the worst place that a warning names, where its line does not lead to it: lines of other
  /// files cannot be asked for, of a line that is repeated only the first places are told, and one
  /// that lowers the tool has no place.
  void find_worst_number() {
    if (!job_.finds_worst_place || !result_.verdict) return;
    const JobVerdict::ToolFigures* const tool = result_.verdict->worst_tool();
    if (tool == nullptr || result_.verdict->decision() != JobDecision::DrillWithWarning) return;
    const JobVerdict::WorstPlace& worst = tool->worst;
    const bool is_of_program = worst.file.empty() && worst.path.empty();
    if (worst.number) {
      if (!is_of_program) result_.worst_number = worst.number;
      return;
    }
    PlaceNumber finder(worst);
    DiagnosticLog ignored;
    ++result_.n_walks;
    execute(job_.program, execution_->counting_walk(), *survey_, finder, ignored);
    if (!is_of_program || !finder.is_of_its_line()) result_.worst_number = finder.number();
  }

  const Job& job_;
  const OpenJobSources& open_;
  MachineConfig machine_;
  const JobSinks& sinks_;
  JobResult result_;
  std::shared_ptr<Survey> survey_;
  CheckedWalk checked_;
  std::unique_ptr<JobExecution> execution_;
};

/// A source that belongs to the caller.
template <class Source>
std::shared_ptr<Source> borrowed(Source& source) {
  return {std::shared_ptr<void>(), &source};
}

}  // namespace

Expected<Job> read_job(const std::string& path,
                       const MachineConfig& machine,
                       std::chrono::sys_seconds now) {
  Job job;
  std::optional<Program> program = read_program(path, machine.reading, job.reading);
  if (!program) return failure(job.reading.kept().front());
  job.program = *std::move(program);
  job.now = now;
  return job;
}

Expected<JobResult> correct(const Job& job,
                            const OpenJobSources& open,
                            const MachineConfig& machine,
                            const JobSinks& sinks) {
  return JobRun(job, open, machine, sinks).run();
}

Expected<JobResult> correct(const Job& job,
                            MeasurementSource& source,
                            const MachineConfig& machine,
                            const JobSinks& sinks) {
  const OpenJobSources open = [&](const Survey& nominal) -> Expected<JobSources> {
    if (!nominal.probes.empty()) {
      return failure({Code::Usage,
                      {job.program.source.file, nominal.probes.front().request.line, 0},
                      "the program probes the surface, and there is no source of readings",
                      "correct() with sources of both"});
    }
    return JobSources{borrowed(source), std::make_shared<NominalProbeSource>(), "the caller"};
  };
  return correct(job, open, machine, sinks);
}

}  // namespace panelcal
