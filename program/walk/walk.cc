// SPDX-License-Identifier: Apache-2.0
#include "program/walk/walk.h"

#include <algorithm>
#include <utility>

#include "program/walk/dialect.h"

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
  dialect_of(program).walk(program, options, survey, {&source, &probes, nullptr, log});
  return survey;
}

void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log) {
  Survey replayed = survey;
  const ProgramDialect& dialect = dialect_of(program);
  sink.begin({.file = program.source.file,
              .dialect = program.dialect,
              .format = program.head->number_format(),
              .tools = program.tools(),
              .is_scaled = dialect.has_reference_scaling() && options.scaling.has_value(),
              .body_rules = program.head->body_rules,
              .axis_version = program.axis_version()});
  dialect.walk(program, options, replayed, {nullptr, nullptr, &sink, log});
}

}  // namespace panelcal
