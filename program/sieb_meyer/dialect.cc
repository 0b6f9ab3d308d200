// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/dialect.h"

#include <memory>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include "program/sieb_meyer/text/file_layout.h"

namespace panelcal::sieb_meyer {
namespace {

class SiebMeyerDialect final : public ProgramDialect {
 public:
  Dialect id() const override { return Dialect::SiebMeyer; }
  bool begins(std::string_view bytes) const override { return is_program(bytes); }
  void read(Program& program, DiagnosticLog& log) const override {
    program.head = std::make_shared<FileLayout>(read_layout(program.source, log, program.reading));
    program.patterns = read_subprograms(program.source.bytes, program.reading.pattern_folders);
  }
  std::optional<std::size_t> walk(const Program& program,
                                  const WalkOptions& options,
                                  Survey& survey,
                                  const WalkEnds& ends) const override {
    Interpreter(program, options, survey, ends).run();
    return std::nullopt;
  }
};

}  // namespace

const ProgramDialect& dialect() {
  static const SiebMeyerDialect kDialect;
  return kDialect;
}

}  // namespace panelcal::sieb_meyer
