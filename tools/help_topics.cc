// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/help_topics.h"

#include <array>
#include <iterator>

#include <fmt/format.h>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/program/excellon/header.h"
#include "panelcal/program/excellon/lexer.h"
#include "panelcal/tools/exit_code.h"

namespace panelcal {
namespace {

std::string diagnostics_page() {
  std::string out =
      "# Diagnostics\n\n"
      "`FILE:LINE:COLUMN: error|warning[CODE]: what, expected ...`\n\n"
      "The exit code is that of the worst error; warnings do not change it.\n\n"
      "| code | severity | exit | meaning | what to do |\n| --- | --- | --- | --- | --- |\n";
  for (const CodeInfo& code : diagnostic_catalogue()) {
    const bool is_error = code.severity == Severity::Error;
    const Diagnostic example{code.code, {}, "", ""};
    fmt::format_to(std::back_inserter(out),
                   "| `{}` | {} | {} | {} | {} |\n",
                   code.slug,
                   is_error ? "error" : "warning",
                   static_cast<int>(exit_code(example)),
                   code.summary,
                   code.advice);
  }
  return out;
}

void append_row(std::string& out,
                std::string_view form,
                excellon::CommandClass command_class,
                std::string_view section,
                std::string_view effect,
                std::string_view test) {
  // A bar inside a table's cell would end it.
  std::string safe(form);
  for (auto at = safe.find('|'); at != std::string::npos; at = safe.find('|', at + 2)) {
    safe.insert(at, 1, '\\');
  }
  fmt::format_to(std::back_inserter(out),
                 "| `{}` | {} | {} | {} | `{}` |\n",
                 safe,
                 name(command_class),
                 effect,
                 section,
                 test);
}

std::string excellon_page() {
  std::string out =
      "# Excellon commands\n\n"
      "Every command of the CNC-7 manual, what panelcal does with it, and the file in "
      "tests/program "
      "that shows it. Nothing is skipped: what is not listed here is an error.\n\n"
      "## Body\n\n"
      "| command | class | what it does | manual section | test |\n"
      "| --- | --- | --- | --- | --- |\n";
  for (const excellon::CommandInfo& command : excellon::command_table()) {
    const std::string code = excellon::code_text(command.command);
    std::string form(command.operands);
    if (form.find(code) == std::string::npos) form = code + form;
    append_row(out, form, command.command_class, command.section, command.effect, command.test);
  }
  for (const excellon::WordInfo& word : excellon::word_table()) {
    append_row(out, word.form, word.command_class, word.section, word.effect, word.test);
  }
  out +=
      "\n## Header\n\n"
      "Besides `T#...`, `#/#/#`, `/` and comments, which are as in the body. *passed*: given to "
      "the "
      "machine in order; tests: `header_test`.\n\n"
      "| word | class | what it does | |\n| --- | --- | --- | --- |\n";
  for (const excellon::HeaderWordInfo& word : excellon::header_word_table()) {
    fmt::format_to(std::back_inserter(out),
                   "| `{}` | {} | {} | {} |\n",
                   word.word,
                   name(word.command_class),
                   word.effect,
                   word.kind);
  }
  out +=
      "\n## Format One\n\n"
      "After FMAT,1 these codes mean others; a Format Two code on the right is then an error.\n\n"
      "| Format One | means |\n| --- | --- |\n";
  for (const excellon::FormatOneInfo& row : excellon::format_one_table()) {
    fmt::format_to(std::back_inserter(out),
                   "| `{}{:02}` | `{}` |\n",
                   row.letter,
                   row.number,
                   excellon::code_text(row.command));
  }
  return out;
}

}  // namespace

std::optional<std::string> help_topic(std::string_view topic) {
  if (topic == "diagnostics") return diagnostics_page();
  if (topic == "excellon") return excellon_page();
  return std::nullopt;
}

}  // namespace panelcal
