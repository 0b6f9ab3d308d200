// SPDX-License-Identifier: Apache-2.0
#include "program/walk/walk.h"

#include <algorithm>
#include <utility>

#include "program/walk/dialect.h"
#include "program/walk/trial_execution.h"

namespace panelcal {

namespace {

const ProgramDialect& dialect_of(const Program& program) {
  return **std::ranges::find(dialects(), program.dialect, &ProgramDialect::id);
}

}  // namespace

Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options) {
  Program program;
  program.source = std::move(source);
  program.reading = std::move(options);
  const auto begins = [&](const ProgramDialect* dialect) {
    return dialect->begins(program.source.bytes);
  };
  const ProgramDialect& dialect = **std::ranges::find_if(dialects(), begins);
  program.dialect = dialect.id();
  dialect.read(program, log);
  return program;
}

Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              DiagnosticLog& log) {
  NominalProbeSource probes;
  return survey(program, options, source, probes, log);
}

Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              ProbeSource& probes,
              DiagnosticLog& log) {
  Survey survey;
  dialect_of(program).walk(
      program, options, survey, {.measurements = &source, .probes = &probes, .log = log});
  return survey;
}

namespace {

/// A perfect panel that tells a trial when it is asked.
class AskedPanel final : public MeasurementSource {
 public:
  explicit AskedPanel(bool& is_asked) : is_asked_(is_asked) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    is_asked_ = true;
    return panel_.measure(request);
  }
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    is_asked_ = true;
    return panel_.focus(request);
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    is_asked_ = true;
    return panel_.calibrate(order);
  }

 private:
  bool& is_asked_;
  NominalSource panel_;
};

class AskedSurface final : public ProbeSource {
 public:
  explicit AskedSurface(bool& is_asked) : is_asked_(is_asked) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    is_asked_ = true;
    return surface_.probe(request);
  }

 private:
  bool& is_asked_;
  NominalProbeSource surface_;
};

void begin(const Program& program, const WalkOptions& options, OperationSink& sink) {
  sink.begin(program_info(program, options));
}

}  // namespace

ProgramInfo program_info(const Program& program, const WalkOptions& options) {
  const ProgramDialect& dialect = dialect_of(program);
  const bool has_scaling = dialect.has_reference_scaling();
  return {.file = program.source.file,
          .dialect = program.dialect,
          .format = program.head->number_format(),
          .tools = program.tools(),
          .is_scaled = has_scaling && options.scaling.has_value(),
          .body_rules = program.head->body_rules,
          .axis_version = program.axis_version(),
          .declares_digits = program.head->declares_digits(),
          .has_decimal_coordinates = dialect.has_decimal_coordinates(program)};
}

CheckedWalk check(const Program& program,
                  const WalkOptions& options,
                  Execution execution,
                  OperationSink* sink,
                  DiagnosticLog& log) {
  CheckedWalk checked;
  WalkOptions without_limits = options;
  without_limits.base_limits = {};
  without_limits.nested_limits = {};
  TrialExecution trial;
  trial.ends_when_asked = execution != Execution::OfNominal;
  AskedPanel panel(trial.is_asked);
  AskedSurface surface(trial.is_asked);
  if (execution == Execution::None) sink = nullptr;
  TrialExecution* const executed = sink == nullptr ? nullptr : &trial;
  if (sink != nullptr) begin(program, options, *sink);
  checked.asks_until = dialect_of(program).walk(
      program,
      without_limits,
      checked.survey,
      {.measurements = &panel, .probes = &surface, .sink = sink, .log = log, .trial = executed});
  checked.asks = trial.is_asked;
  checked.is_executed = sink != nullptr && !trial.is_over();
  checked.working_log = std::move(trial.working_log);
  return checked;
}

CheckedWalk check(const Program& program, const WalkOptions& options, DiagnosticLog& log) {
  return check(program, options, Execution::None, nullptr, log);
}

Survey survey(const Program& program,
              const WalkOptions& options,
              const CheckedWalk& checked,
              MeasurementSource& source,
              ProbeSource& probes,
              DiagnosticLog& log) {
  Survey survey;
  dialect_of(program).walk(
      program,
      options,
      survey,
      {.measurements = &source, .probes = &probes, .log = log, .asks_until = checked.asks_until});
  return survey;
}

void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log) {
  Survey replayed = survey;
  begin(program, options, sink);
  dialect_of(program).walk(program, options, replayed, {.sink = &sink, .log = log});
}

}  // namespace panelcal
