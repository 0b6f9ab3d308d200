// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/machine_config.h"
#include "panelcal/tools/commands.h"
#include "panelcal/tools/program_input.h"

namespace panelcal {

ExitCode run_command(const SurveyOptions& options, CommandContext& context) {
  auto config = read_machine_config(options.machine);
  if (!config) {
    context.console.print(config.error());
    return exit_code(config.error());
  }
  config->walk.max_operations = options.max_operations;
  DiagnosticLog log;
  const auto checked = read_and_check(options.program, config->reading, config->walk, log);
  context.console.print(log);
  if (log.has_errors()) return exit_code(log);

  std::string lines;
  for (const Measurement& measurement : checked->nominal_survey.measurements) {
    lines += to_json(measurement.request) + "\n";
  }
  const auto written = context.output.write(lines);
  if (written) return ExitCode::Done;
  context.console.print(written.error());
  return exit_code(written.error());
}

}  // namespace panelcal
