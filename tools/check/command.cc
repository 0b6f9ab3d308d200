// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <optional>
#include <utility>

#include "calib/base/clock.h"
#include "machine/config/machine_config.h"
#include "program/excellon/header.h"
#include "program/judge/job_check.h"
#include "program/judge/tally.h"
#include "program/sieb_meyer/file_layout.h"
#include "tools/cli/commands.h"
#include "tools/cli/program_input.h"
#include "tools/cli/text_variables.h"
#include "tools/run/spindle_age.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string count(std::size_t n, std::string_view word) {
  return fmt::format("{} {}{}", n == 0 ? "no" : std::to_string(n), word, n == 1 ? "" : "s");
}

/// "Excellon, metric 3.3, trailing zeros kept (line 9: METRIC,TZ)": the language, how numbers are
/// read, and why.
std::string reading(const Program& program) {
  if (program.dialect == Dialect::SiebMeyer) {
    return fmt::format("{}, {} (line {})",
                       name(program.dialect),
                       program.number_summary(),
                       sieb_meyer::layout_of(program).head_line);
  }
  const excellon::Header& header = excellon::header_of(program);
  return fmt::format("Excellon{}, {} ({})",
                     header.set == excellon::ProgramSet::FormatOne ? " Format One" : "",
                     program.number_summary(),
                     header.states_format ? header.format_evidence : "not stated, assumed");
}

std::string summary(const CheckedProgram& checked, const Tally& tally, const DiagnosticLog& log) {
  const Survey& survey = checked.nominal_survey;
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
  job += fmt::format(
      ", {} in {} series", count(survey.measurements.size(), "target"), survey.series.size());
  if (!survey.probes.empty()) job += ", " + count(survey.probes.size(), "probe");
  return fmt::format("{}: {}\n{}, no errors, {}\n",
                     checked.program.source.file,
                     reading(checked.program),
                     job,
                     count(log.n_warnings(), "warning"));
}

}  // namespace

ExitCode run_command(const CheckOptions& options, CommandContext& context) {
  DiagnosticLog log;
  WalkOptions walk;
  ReadOptions reading;
  std::optional<Travel> travel;
  const std::chrono::sys_seconds now = system_clock()();
  const auto time = wall_time(options.clock, now);
  if (!time) {
    context.console.print(time.error());
    return exit_code(time.error());
  }
  if (!options.machine.empty()) {
    auto config = read_machine_config(options.machine);
    if (!config) {
      context.console.print(config.error());
      return exit_code(config.error());
    }
    if (const auto aged = age_offset(*config, options.clock, now); !aged) {
      context.console.print(aged.error());
      return exit_code(aged.error());
    }
    walk = config->walk;
    reading = config->reading;
    travel = config->travel;
  }
  walk.max_operations = options.max_operations;
  set_text_variables(options.program, *time, walk.sieb_meyer.text);
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
