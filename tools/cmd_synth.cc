// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/sim/recording.h"
#include "panelcal/machine/sim/sim_machine.h"
#include "panelcal/tools/commands.h"
#include "panelcal/tools/program_input.h"

namespace panelcal {
namespace {

Expected<Recording> synthesize(const SynthOptions& options,
                               MachineConfig config,
                               const Program& program,
                               DiagnosticLog& log) {
  if (options.seed && config.sim) config.sim->seed = *options.seed;
  PANELCAL_TRY(const SimMachine machine, SimMachine::create(config, program));
  PANELCAL_TRY(Recording recording, record_pictures(program, config, machine, options.output, log));
  PANELCAL_CHECK(
      write_truth_json(std::filesystem::path(options.output) / "truth.json", machine.truth()));
  return recording;
}

}  // namespace

ExitCode run_command(const SynthOptions& options, CommandContext& context) {
  const auto config = read_machine_config(options.machine);
  if (!config) {
    context.console.print(config.error());
    return exit_code(config.error());
  }
  DiagnosticLog log;
  const auto checked = read_and_check(options.program, config->reading, config->walk, log);
  context.console.print(log);
  if (log.has_errors()) return exit_code(log);

  DiagnosticLog found;
  const auto recording = synthesize(options, *config, checked->program, found);
  for (const Diagnostic& diagnostic : found.kept()) {
    if (diagnostic.severity() == Severity::Error) context.console.print(diagnostic);
  }
  if (!recording) {
    context.console.print(recording.error());
    return exit_code(recording.error());
  }
  context.console.say(fmt::format("{} pictures, images.csv and truth.json written to {}",
                                  recording->rows.size(),
                                  options.output));
  return exit_code(found);
}

}  // namespace panelcal
