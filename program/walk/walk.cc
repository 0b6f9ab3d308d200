// SPDX-License-Identifier: Apache-2.0
#include "program/walk/walk.h"

#include <utility>

#include "program/excellon/interpreter.h"
#include "program/excellon/stored_patterns.h"
#include "program/sieb_meyer/interpreter.h"
#include "program/sieb_meyer/subprograms.h"

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

void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log) {
  Survey replayed = survey;
  const bool is_excellon = program.dialect == Dialect::Excellon;
  sink.begin({.file = program.source.file,
              .dialect = program.dialect,
              .format = is_excellon ? program.header.format : sieb_meyer::kMetricFormat,
              .tools = program.tools(),
              .is_scaled = is_excellon && options.scaling.has_value(),
              .body_rules = program.header.body_rules,
              .axis_version = program.axis_version()});
  if (is_excellon) {
    excellon::Interpreter(program, options, replayed, nullptr, &sink, log).run();
  } else {
    sieb_meyer::Interpreter(program, options, replayed, {nullptr, nullptr, &sink, log}).run();
  }
}

}  // namespace panelcal
