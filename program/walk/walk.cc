// SPDX-License-Identifier: Apache-2.0
#include "program/walk/walk.h"

#include <utility>

#include "program/excellon/interpreter.h"
#include "program/excellon/stored_patterns.h"
#include "program/sieb_meyer/interpreter.h"
#include "program/sieb_meyer/subprograms.h"
#include "program/walk/trial_execution.h"

namespace panelcal {

Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options) {
  Program program;
  program.source = std::move(source);
  program.reading = std::move(options);
  const ReadOptions& reading = program.reading;
  if (sieb_meyer::is_program(program.source.bytes)) {
    program.dialect = Dialect::SiebMeyer;
    program.layout = sieb_meyer::read_layout(program.source, log);
    program.patterns = sieb_meyer::read_subprograms(program.source.bytes, reading.pattern_folders);
  } else {
    program.header = excellon::read_header(program.source, reading.diameter_page, log);
    program.patterns = excellon::read_patterns(program.source.bytes, reading.pattern_folders);
  }
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
  if (program.dialect == Dialect::SiebMeyer) {
    sieb_meyer::Interpreter(program, options, survey, {&source, &probes, nullptr, log}).run();
  } else {
    excellon::Interpreter(program, options, survey, &source, nullptr, log).run();
  }
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
  const bool is_excellon = program.dialect == Dialect::Excellon;
  sink.begin({.file = program.source.file,
              .dialect = program.dialect,
              .format = is_excellon ? program.header.format : sieb_meyer::kMetricFormat,
              .tools = program.tools(),
              .is_scaled = is_excellon && options.scaling.has_value(),
              .body_rules = program.header.body_rules,
              .axis_version = program.axis_version()});
}

}  // namespace

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
  if (program.dialect == Dialect::Excellon) {
    excellon::Interpreter interpreter(
        program, without_limits, checked.survey, &panel, sink, log, executed);
    interpreter.run();
    checked.asks_until = interpreter.asked_until();
  } else {
    sieb_meyer::Interpreter(
        program, without_limits, checked.survey, {&panel, &surface, sink, log, executed})
        .run();
  }
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
  if (!checked.asks_until) return survey(program, options, source, probes, log);
  Survey survey;
  excellon::Interpreter interpreter(program, options, survey, &source, nullptr, log);
  interpreter.end_at(*checked.asks_until);
  interpreter.run();
  return survey;
}

void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log) {
  Survey replayed = survey;
  const bool is_excellon = program.dialect == Dialect::Excellon;
  begin(program, options, sink);
  if (is_excellon) {
    excellon::Interpreter(program, options, replayed, nullptr, &sink, log).run();
  } else {
    sieb_meyer::Interpreter(program, options, replayed, {nullptr, nullptr, &sink, log}).run();
  }
}

}  // namespace panelcal
