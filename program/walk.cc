// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/walk.h"

#include <utility>

#include "panelcal/program/excellon/interpreter.h"
#include "panelcal/program/excellon/stored_patterns.h"

namespace panelcal {

bool Program::deletes_blocks() const {
  return header.block_delete.value_or(reading.block_delete.value_or(false));
}

Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options) {
  Program program{std::move(source), {}, {}, std::move(options)};
  program.header = excellon::read_header(program.source, program.reading.diameter_page, log);
  program.patterns = excellon::read_patterns(program.source.bytes, program.reading.pattern_folders);
  return program;
}

Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              DiagnosticLog& log) {
  Survey survey;
  excellon::Interpreter(program, options, survey, &source, nullptr, log).run();
  return survey;
}

void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log) {
  Survey replayed = survey;
  sink.begin({.file = program.source.file,
              .format = program.header.format,
              .tools = program.header.tools,
              .is_scaled = options.scaling.has_value(),
              .body_rules = program.header.body_rules,
              .axis_version = program.axis_version()});
  excellon::Interpreter(program, options, replayed, nullptr, &sink, log).run();
}

}  // namespace panelcal
