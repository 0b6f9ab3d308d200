// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "panelcal/machine/machine_config.h"
#include "panelcal/tools/commands.h"
#include "panelcal/tools/program_input.h"

namespace panelcal {
namespace {

std::string count(std::size_t n, std::string_view word) {
  return fmt::format("{} {}{}", n == 0 ? "no" : std::to_string(n), word, n == 1 ? "" : "s");
}

std::string summary(const CheckedProgram& checked, const Tally& tally, const DiagnosticLog& log) {
  const Survey& survey = checked.nominal_survey;
  const excellon::Header& header = checked.program.header;
  return fmt::format("{}: Excellon, {} ({})\n{}, {}, {} in {} series, no errors, {}\n",
                     checked.program.source.file,
                     header.format.summary(),
                     header.states_format ? header.format_evidence : "not stated, assumed",
                     count(tally.holes_by_tool().size(), "tool"),
                     count(static_cast<std::size_t>(tally.n_holes()), "hole"),
                     count(survey.measurements.size(), "target"),
                     survey.series.size(),
                     count(log.n_warnings(), "warning"));
}

}  // namespace

ExitCode run_command(const CheckOptions& options, CommandContext& context) {
  DiagnosticLog log;
  WalkOptions walk;
  if (!options.machine.empty()) {
    auto config = read_machine_config(options.machine);
    if (!config) {
      context.console.print(config.error());
      return exit_code(config.error());
    }
    walk = config->walk;
  }
  walk.max_operations = options.max_operations;
  std::string result;
  if (!options.program.empty()) {
    const auto checked = read_and_check(options.program, walk, log);
    const Tally tally = log.has_errors() ? Tally() : tally_nominal(*checked, walk, log);
    context.console.print(log);
    if (log.has_errors()) {
      context.console.say(fmt::format("{}: {}, {}",
                                      options.program,
                                      count(log.n_errors(), "error"),
                                      count(log.n_warnings(), "warning")));
      return exit_code(log);
    }
    result = summary(*checked, tally, log);
  } else if (options.machine.empty()) {
    const Diagnostic nothing{Code::Usage,
                             {"panelcal check", 0, 0},
                             "nothing to check",
                             "PROGRAM, -m machine.toml, or both"};
    context.console.print(nothing);
    return exit_code(nothing);
  } else {
    result = options.machine + ": no errors\n";
  }
  const auto written = context.output.write(result);
  if (written) return ExitCode::Done;
  context.console.print(written.error());
  return exit_code(written.error());
}

}  // namespace panelcal
