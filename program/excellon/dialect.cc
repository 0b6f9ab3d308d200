// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/dialect.h"

#include <memory>

#include "program/excellon/interpreter/interpreter.h"
#include "program/excellon/patterns/stored_patterns.h"
#include "program/excellon/text/header.h"

namespace panelcal::excellon {
namespace {

class ExcellonDialect final : public ProgramDialect {
 public:
  Dialect id() const override { return Dialect::Excellon; }
  bool begins(std::string_view /*bytes*/) const override { return true; }
  void read(Program& program, DiagnosticLog& log) const override {
    const ReadOptions& reading = program.reading;
    program.head =
        std::make_shared<Header>(read_header(program.source, reading.diameter_page, log));
    program.patterns = read_patterns(program.source.bytes, reading.pattern_folders);
  }
  bool has_reference_scaling() const override { return true; }
  std::optional<std::size_t> walk(const Program& program,
                                  const WalkOptions& options,
                                  Survey& survey,
                                  const WalkEnds& ends) const override {
    Interpreter interpreter(
        program, options, survey, ends.measurements, ends.sink, ends.log, ends.trial);
    if (ends.asks_until) interpreter.end_at(*ends.asks_until);
    interpreter.run();
    return interpreter.asked_until();
  }
};

}  // namespace

const ProgramDialect& dialect() {
  static const ExcellonDialect kDialect;
  return kDialect;
}

}  // namespace panelcal::excellon
