// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/dialect.h"

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "program/sieb_meyer/interpreter/interpreter.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include "program/sieb_meyer/text/file_layout.h"
#include "program/text/gaps.h"
#include "program/walk/reporter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// The line of two percent signs ahead of a file's first subprogram, if there is one: the manual
/// has none.
std::optional<SourceLine> find_mark(std::string_view bytes) {
  LineCursor cursor(bytes);
  while (!cursor.at_end()) {
    const SourceLine line = cursor.next();
    if (line.text.starts_with("%%")) return line;
    if (line.text.starts_with('@')) break;
  }
  return std::nullopt;
}

/// Refuses the call of a subprogram that may be in the numbers of the program or of the control.
void refuse_call(const Program& program, std::string_view name, const Reporter& reporter) {
  const FileLayout& layout = layout_of(program);
  const std::string call = "M99," + std::string(name);
  LineCursor cursor(program.source.bytes, layout.body);
  while (cursor.offset() < layout.body_end) {
    const SourceLine line = cursor.next();
    const std::size_t at = line.text.find(call);
    if (at == std::string_view::npos) continue;
    return reporter.report(Code::FormatAmbiguous,
                           line.number,
                           line.column + static_cast<int>(at),
                           fmt::format("{} is in the numbers of %%{} or in those of {}",
                                       quoted(name),
                                       layout.setting,
                                       program.reading.last_format.from),
                           "--format with a unit, zeros and digits, which holds for both");
  }
}

/// Subprograms have no format of their own: they are in the numbers of the program that calls them.
void check_numbers_of_subprograms(const Program& program, DiagnosticLog& log) {
  const FileLayout& layout = layout_of(program);
  const Reporter reporter(program.source.file, log);
  for (const auto& [name, source] : program.patterns) {
    const auto mark = find_mark(source.bytes);
    if (!mark && layout.leaves_subprograms) refuse_call(program, name, reporter);
    if (!mark || trimmed(mark->text) == "%%" + layout.setting) continue;
    Reporter(source.file, log)
        .report(Code::CommandFormat,
                mark->number,
                mark->column,
                quoted(mark->text),
                "the format of the program that calls it, %%" + layout.setting);
  }
}

class SiebMeyerDialect final : public ProgramDialect {
 public:
  Dialect id() const override { return Dialect::SiebMeyer; }
  bool begins(std::string_view bytes) const override { return is_program(bytes); }
  void read(Program& program, DiagnosticLog& log) const override {
    program.head = std::make_shared<FileLayout>(read_layout(program.source, log, program.reading));
    program.patterns = read_subprograms(program.source.bytes, program.reading.pattern_folders);
    check_numbers_of_subprograms(program, log);
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
