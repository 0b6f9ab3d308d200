// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/walk.h"

#include <utility>

#include "panelcal/program/excellon/interpreter.h"

namespace panelcal {

Program load_program(SourceText source, DiagnosticLog& log) {
  Program program{std::move(source), {}};
  program.header = excellon::read_header(program.source, log);
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
  sink.begin({program.source.file, program.header.format, program.header.tools});
  excellon::Interpreter(program, options, replayed, nullptr, &sink, log).run();
}

}  // namespace panelcal
