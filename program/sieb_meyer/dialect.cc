// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/dialect.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "program/sieb_meyer/interpreter/parts.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/file_layout.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/text/gaps.h"
#include "program/walk/reporter.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// The last line of two percent signs ahead of a subprogram, if there is one: the manual has none.
/// Files that were joined have one each.
std::optional<SourceLine> find_mark(std::string_view bytes, std::string_view name) {
  LineCursor cursor(bytes);
  std::optional<SourceLine> mark;
  while (!cursor.at_end()) {
    SourceLine line = cursor.next();
    const std::size_t n_blanks = std::min(line.text.find_first_not_of(" \t"), line.text.size());
    line.column += static_cast<int>(n_blanks);
    line.text = trimmed(line.text);
    if (line.text.starts_with("%%")) mark = line;
    if (line.text.starts_with('@') && trimmed(line.text.substr(1)) == name) break;
  }
  return mark;
}

/// A length or a feed, which has a unit.
bool has_unit(const Word& word) {
  return std::string_view("XYRIJDHKZF").find(word.letter) != std::string_view::npos;
}

/// A number whose reading depends on the zeros and digits of the format.
bool has_bare_length(const Block& block) {
  const auto is_bare_length = [](const Word& word) {
    return has_unit(word) && is_bare(word.number);
  };
  if (std::ranges::any_of(block.all(), is_bare_length)) return true;
  if (block.n_words == 0 || block.all().back().letter != 'M' ||
      command_of(block.all().back()) != Command::CncCommand) {
    return false;
  }
  const auto command = find_cnc_command(block.argument);
  return command && states_lengths(*command) && has_bare_number(command->argument);
}

bool has_bare_length(std::string_view bytes, const SubprogramText& body) {
  LineCursor cursor(bytes, body.begin);
  Block block;
  while (!cursor.at_end() && cursor.offset() < body.end) {
    const SourceLine line = cursor.next();
    // A line that is no block is an error where it is executed.
    if (!lex(without_slash(line).value_or(line), block) && has_bare_length(block)) return true;
  }
  return false;
}

bool leaves_open(SubprogramNumbers numbers, std::string_view bytes, std::string_view name) {
  if (numbers != SubprogramNumbers::OpenWithoutPoint) return numbers == SubprogramNumbers::Open;
  const auto body = find_subprogram(bytes, name);
  return body && has_bare_length(bytes, *body);
}

struct CallPlace {
  std::string_view file;
  int line = 0;
  int column = 0;
};

std::optional<CallPlace> find_place(const SourceText& source,
                                    LinePlace begin,
                                    std::size_t end,
                                    std::string_view name) {
  const std::string_view lines = std::string_view(source.bytes).substr(0, end);
  const auto at = find_call(lines.substr(begin.offset), name);
  if (!at) return std::nullopt;
  const std::size_t offset = begin.offset + *at;
  LineCursor cursor(lines, begin);
  while (true) {
    const std::size_t line_offset = cursor.offset();
    const SourceLine line = cursor.next();
    if (cursor.offset() <= offset) continue;
    return CallPlace{source.file, line.number, static_cast<int>(offset - line_offset) + 1};
  }
}

/// The call in the program or in another subprogram; the %%, if a comment ahead of it has the name.
CallPlace place_of_call(const Program& program, std::string_view name) {
  const FileLayout& layout = layout_of(program);
  if (auto place = find_place(program.source, layout.body, layout.body_end, name)) return *place;
  for (const auto& [caller, source] : program.patterns) {
    const auto body = find_subprogram(source.bytes, caller);
    if (!body) continue;
    if (auto place = find_place(source, body->begin, body->end, name)) return *place;
  }
  return {program.source.file, layout.head_line, 1};
}

/// Refuses the call of a subprogram that may be in the numbers of the program or of the control.
void refuse_call(const Program& program, std::string_view name, DiagnosticLog& log) {
  const CallPlace place = place_of_call(program, name);
  Reporter(std::string(place.file), log)
      .report(Code::FormatAmbiguous,
              place.line,
              place.column,
              fmt::format("{} is in the numbers of %%{} or in those of {}",
                          quoted(name),
                          layout_of(program).setting,
                          program.reading.last_format.from),
              "--format with a unit, zeros and digits, which holds for both");
}

/// Subprograms have no format of their own: they are in the numbers of the program that calls them.
void check_numbers_of_subprograms(const Program& program, DiagnosticLog& log) {
  const FileLayout& layout = layout_of(program);
  for (const auto& [name, source] : program.patterns) {
    const auto mark = find_mark(source.bytes, name);
    if (!mark && leaves_open(layout.subprograms, source.bytes, name))
      refuse_call(program, name, log);
    if (!mark || mark->text == "%%" + layout.setting) continue;
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
    Walk walk(program, options, survey, ends);
    run(walk);
    return std::nullopt;
  }
};

}  // namespace

const ProgramDialect& dialect() {
  static const SiebMeyerDialect kDialect;
  return kDialect;
}

}  // namespace panelcal::sieb_meyer
