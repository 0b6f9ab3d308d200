// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/command.h"

#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/sim/pictures/recording.h"
#include "machine/sim/pictures/sample_pictures.h"
#include "machine/sim/sim_machine.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

Expected<Recording> synthesize(const SynthOptions& options,
                               MachineConfig config,
                               const Program& program,
                               DiagnosticLog& log) {
  if (options.seed && config.sim) config.sim->seed = *options.seed;
  PANELCAL_TRY(SimMachine machine, SimMachine::create(config, program));
  return record_pictures(program, config, machine, options.output, log);
}

Expected<Answer> run_samples(const SynthOptions& options,
                             MachineConfig config,
                             CommandContext& context) {
  if (options.seed && config.sim) config.sim->seed = *options.seed;
  PANELCAL_TRY(const SampleRenderer renderer, SampleRenderer::create(config, *options.tool));
  PANELCAL_TRY(const SampleSet samples, write_samples(renderer, options.count, options.output));
  context.console.say(fmt::format(
      "{} pictures and truth.json written to {}", samples.pictures.size(), options.output));
  return Answer{};
}

}  // namespace

Expected<Answer> run_command(const SynthOptions& options, CommandContext& context) {
  if (!options.sweep.empty()) return synth::run_sweep(options, context);
  PANELCAL_TRY(MachineConfig config, read_machine_config(options.machine));
  if (options.tool) return run_samples(options, std::move(config), context);
  config.reading.take(options.reading);
  DiagnosticLog log;
  const auto checked = read_and_check(options.program, config.reading, config.walk, log);
  context.console.print(log);
  if (log.has_errors()) return Answer{{}, exit_code(log)};
  PANELCAL_CHECK(check_patterns(context.options, checked->program, context.files));

  DiagnosticLog found;
  const auto recording = synthesize(options, std::move(config), checked->program, found);
  for (const Diagnostic& diagnostic : found.kept()) {
    if (diagnostic.severity() == Severity::Error) context.console.print(diagnostic);
  }
  if (!recording) return failure(recording.error());
  context.console.say(fmt::format("{} pictures, images.csv and truth.json written to {}",
                                  recording->rows.size(),
                                  options.output));
  return Answer{{}, exit_code(found)};
}

}  // namespace panelcal
