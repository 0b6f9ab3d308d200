// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/dialect.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/excellon/interpreter/parts.h"
#include "program/excellon/patterns/stored_patterns.h"
#include "program/excellon/text/header.h"
#include "program/excellon/text/header_reader.h"
#include "program/excellon/text/spelling.h"
#include "program/gcode/recognition.h"
#include "program/text/decimal_points.h"
#include "program/text/gaps.h"

namespace panelcal::excellon {
namespace {

/// Why a text is no program of this language, if it is not.
std::optional<Diagnostic> foreign(const SourceText& source) {
  if (const auto line = gcode::line_of_gcode(source.bytes)) {
    return Diagnostic{Code::NotAProgram,
                      {source.file, line->number, 1},
                      quoted(trimmed(line->text)) + " is G-code, the language of a machine control",
                      "the drill or rout file that it was made of; `panelcal align apply` moves "
                      "G-code to where a board lies, `panelcal surface apply` follows its heights"};
  }
  const ForeignText found = find_foreign(source.bytes);
  if (found.line == 0) return std::nullopt;
  return Diagnostic{Code::NotAProgram,
                    {source.file, found.line, 1},
                    quoted(found.text) + " begins neither Excellon nor SIEB & MEYER",
                    "M48, or %%5000"};
}

bool refuse_foreign(Program& program, DiagnosticLog& log) {
  std::optional<Diagnostic> problem = foreign(program.source);
  if (!problem) return false;
  const auto header = std::make_shared<Header>();
  header->is_refused = true;
  program.head = header;
  log.add(*std::move(problem));
  return true;
}

/// The stored patterns that a text calls, in the manual's characters.
std::map<std::string, SourceText, std::less<>> respelled_patterns(std::string_view text,
                                                                  const ReadOptions& reading,
                                                                  DiagnosticLog& log) {
  auto patterns = read_patterns(text, reading.pattern_folders);
  for (auto& [name, pattern] : patterns) {
    std::string respelled = respell(pattern.bytes, Reporter(pattern.file, log)).text;
    if (!respelled.empty()) pattern.bytes = std::move(respelled);
  }
  return patterns;
}

class ExcellonDialect final : public ProgramDialect {
 public:
  Dialect id() const override { return Dialect::Excellon; }
  bool begins(std::string_view /*bytes*/) const override { return true; }
  void read(Program& program, DiagnosticLog& log) const override {
    if (refuse_foreign(program, log)) return;
    const ReadOptions& reading = program.reading;
    const auto pattern_texts = [&](std::string_view text) {
      DiagnosticLog unheard;
      std::vector<std::string> texts;
      for (auto& [name, pattern] : respelled_patterns(text, reading, unheard)) {
        texts.push_back(std::move(pattern.bytes));
      }
      return texts;
    };
    const auto header =
        std::make_shared<Header>(read_header(program.source, reading, log, pattern_texts));
    program.head = header;
    if (!header->calls_patterns) return;
    program.patterns = respelled_patterns(text_of(program), reading, log);
  }
  bool has_reference_scaling() const override { return true; }
  bool has_decimal_coordinates(const Program& program) const override {
    return panelcal::has_decimal_coordinates(text_of(program));
  }
  std::optional<std::size_t> walk(const Program& program,
                                  const WalkOptions& options,
                                  Survey& survey,
                                  const WalkEnds& ends) const override {
    if (header_of(program).is_refused) return std::nullopt;
    Walk walk(program, options, survey, ends);
    if (ends.asks_until) walk.end_at(*ends.asks_until);
    run(walk);
    return walk.asked_until;
  }
};

}  // namespace

const ProgramDialect& dialect() {
  static const ExcellonDialect kDialect;
  return kDialect;
}

}  // namespace panelcal::excellon
