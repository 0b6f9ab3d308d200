// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "panelcal/machine/machine_config.h"
#include "panelcal/program/job_check.h"
#include "panelcal/program/tally.h"
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
  const bool is_format_one = header.set == excellon::ProgramSet::FormatOne;
  std::string job = count(tally.tools_used().size(), "tool") + ", " +
                    count(static_cast<std::size_t>(tally.n_holes()), "hole");
  if (tally.n_slots() > 0) {
    job += ", " + count(static_cast<std::size_t>(tally.n_slots()), "slot");
  }
  if (tally.n_routs() > 0) {
    job += fmt::format(", {} over {:.1f} mm",
                       count(static_cast<std::size_t>(tally.n_routs()), "rout move"),
                       tally.routed_length().in_mm());
  }
  return fmt::format("{}: Excellon{}, {} ({})\n{}, {} in {} series, no errors, {}\n",
                     checked.program.source.file,
                     is_format_one ? " Format One" : "",
                     header.format.summary(),
                     header.states_format ? header.format_evidence : "not stated, assumed",
                     job,
                     count(survey.measurements.size(), "target"),
                     survey.series.size(),
                     count(log.n_warnings(), "warning"));
}

}  // namespace

ExitCode run_command(const CheckOptions& options, CommandContext& context) {
  DiagnosticLog log;
  WalkOptions walk;
  ReadOptions reading;
  std::optional<Travel> travel;
  if (!options.machine.empty()) {
    auto config = read_machine_config(options.machine);
    if (!config) {
      context.console.print(config.error());
      return exit_code(config.error());
    }
    walk = config->walk;
    reading = config->reading;
    travel = config->travel;
  }
  walk.max_operations = options.max_operations;
  std::string result;
  if (!options.program.empty()) {
    walk.slots = walk.step_slots = Cycles::Kept;
    const auto checked = read_and_check(options.program, std::move(reading), walk, log);
    Tally tally;
    if (!log.has_errors()) {
      JobCheck job_check(travel);
      Tee tee({&tally, &job_check});
      execute_nominal(*checked, walk, tee, log);
      job_check.report(checked->program, log);
    }
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
