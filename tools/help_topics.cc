// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/help_topics.h"

#include <array>
#include <iterator>

#include <fmt/format.h>

#include "panelcal/calib/base/diagnostic.h"
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

std::string excellon_page() {
  std::string out =
      "# Excellon commands\n\n"
      "Every body command of the CNC-7 manual. What is not supported yet is refused by name "
      "(`not-supported`), never skipped.\n\n"
      "| command | operands | manual section | state |\n| --- | --- | --- | --- |\n";
  for (const excellon::CommandInfo& command : excellon::command_table()) {
    fmt::format_to(std::back_inserter(out),
                   "| `{}{:02}` | `{}` | {} | {} |\n",
                   command.letter,
                   command.number,
                   command.operands.empty() ? " " : command.operands,
                   command.section,
                   command.runs ? "executed" : "not yet");
  }
  return out +
         "\nBesides these: coordinates `X#Y#`, `R#X#Y#` (Repeat Hole), `R#M02X#Y#` (Repeat Block), "
         "`T#(#)` with C, F, S, B, H and Z (Tool Commands), `%`, tool links `#/#/#` and `/`, "
         "comments `;`, and the `$uvis` commands auto, box, search, searcharea, entry, insp, lamp, "
         "zoom and alg. `$uvis,focus` and `$uvis,calib` are passed on with a warning.\n";
}

}  // namespace

std::optional<std::string> help_topic(std::string_view topic) {
  if (topic == "diagnostics") return diagnostics_page();
  if (topic == "excellon") return excellon_page();
  return std::nullopt;
}

}  // namespace panelcal
