// SPDX-License-Identifier: Apache-2.0
#include "tools/history/job.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "calib/base/clock.h"
#include "machine/calibrate/kinds/spindle_camera.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "machine/sources/measurement_file_source.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

Diagnostic history_diff_usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal history diff", 0, 0}, std::move(what), std::move(expected)};
}

Expected<void> check_options(const HistoryOptions& options, const CalibrationEntry& before) {
  if (options.machine_file.empty()) {
    return failure(history_diff_usage("--program without a machine file", "-m machine.toml"));
  }
  if (!options.measurements.empty() && before.entry.record.key.kind == LedgerKind::SpindleCamera) {
    return failure(history_diff_usage("--measurements with spindle-camera offsets",
                                      "none: they move every target alike, wherever it was seen"));
  }
  return {};
}

/// The first error of a log; everything else in it is said.
std::optional<Diagnostic> take_first_error(const DiagnosticLog& log, Console& console) {
  std::optional<Diagnostic> first;
  DiagnosticLog others;
  for (const Diagnostic& diagnostic : log.kept()) {
    if (!first && diagnostic.severity() == Severity::Error) {
      first = diagnostic;
    } else {
      others.add(diagnostic);
    }
  }
  console.print(others);
  return first;
}

class JobRun {
 public:
  JobRun(const HistoryOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Expected<void> read_job() {
    PANELCAL_TRY(config_, read_machine_config(options_.machine_file));
    if (options_.measurements.empty()) {
      // Targets that are where they are drawn speak for no model.
      config_.walk.chooses_model = false;
    }
    PANELCAL_CHECK(set_walk_terms({.program = options_.program,
                                   .clock = options_.clock,
                                   .now = system_clock()(),
                                   .max_operations = options_.max_operations,
                                   .reading = options_.reading,
                                   .ages_offset = false,
                                   .command = "panelcal history"},
                                  config_));
    PANELCAL_CHECK(measure());
    return {};
  }

  const MachineConfig& config() const { return config_; }
  const Program& program() const { return *program_; }
  const Survey& before() const { return before_; }

 private:
  Expected<void> measure() {
    DiagnosticLog log;
    program_ = read_program(options_.program, config_.reading, log);
    if (program_) PANELCAL_CHECK(check_patterns(context_.options, *program_, context_.files));
    if (program_ && !log.has_errors()) {
      if (options_.measurements.empty()) {
        before_ = survey_nominal(*program_, config_.walk, log);
      } else {
        PANELCAL_CHECK(measure_as_recorded(log));
      }
    }
    if (auto error = take_first_error(log, context_.console)) return failure(*std::move(error));
    return {};
  }

  Expected<void> measure_as_recorded(DiagnosticLog& log) {
    PANELCAL_TRY(RecordedMeasurements recorded, read_measurements(options_.measurements));
    MeasurementFileSource source(std::move(recorded));
    WalkOptions without_limits = config_.walk;
    without_limits.base_limits = {};
    without_limits.nested_limits = {};
    before_ = survey(*program_, without_limits, source, log);
    if (log.has_errors()) return {};
    return source.check_all_used();
  }

  const HistoryOptions& options_;
  CommandContext& context_;
  MachineConfig config_;
  std::optional<Program> program_;
  Survey before_;
};

/// The job is drilled with one spindle, and no other one's offset moves it.
Expected<void> check_spindle(const MachineConfig& config, const LedgerEntry& entry) {
  const LedgerKey& key = entry.record.key;
  const std::string drills = spindle_camera_key(config).subject;
  if (key.kind != LedgerKind::SpindleCamera || key.subject == drills) return {};
  return failure(history_diff_usage(fmt::format("entry {} is of {}, but {} drills with {}",
                                                entry.id,
                                                key.subject,
                                                config.file.string(),
                                                drills),
                                    "[spindle] number and station of the entry"));
}

Expected<void> check_machine(const MachineConfig& config, const LedgerEntry& entry) {
  const std::string& machine = entry.record.key.machine;
  if (config.name.empty() || config.name == machine) return {};
  return failure(history_diff_usage(fmt::format("entry {} is of {}, {} describes {}",
                                                entry.id,
                                                quoted(std::string_view(machine)),
                                                config.file.string(),
                                                quoted(std::string_view(config.name))),
                                    "the file of that machine"));
}

LookingMachine machine_of(const MachineConfig& config) {
  const auto& table = config.walk.table;
  return {config.spindle_camera, table == nullptr ? Length() : table->hold()};
}

}  // namespace

Expected<AnswerPart> job_answer(const HistoryOptions& options,
                                CommandContext& context,
                                const CalibrationEntry& before,
                                const CalibrationEntry& after) {
  PANELCAL_CHECK(check_options(options, before));
  JobRun job(options, context);
  PANELCAL_CHECK(job.read_job());
  PANELCAL_TRY(CalibrationChange change,
               change_between(before, after, options.ledger, machine_of(job.config())));
  PANELCAL_CHECK(check_machine(job.config(), before.entry));
  PANELCAL_CHECK(check_spindle(job.config(), before.entry));
  PANELCAL_TRY(const std::optional<JobShift> shift,
               job_shift(job.program(), job.config().walk, job.before(), change));
  if (!shift) {
    return failure({Code::Usage,
                    {options.program, 0, 0},
                    "the program has no hole, slot or rout move",
                    "a program that works somewhere"});
  }
  JobShiftWords words = {job.program().source.file, {}};
  if (options.measurements.empty()) words.notes = std::move(change.notes);
  return AnswerPart{
      job_shift_text(*shift, words),
      job_shift_facts(*shift, words),
      provenance_of(context.options, job.program(), {options.machine_file, options.measurements})};
}

}  // namespace panelcal::history
