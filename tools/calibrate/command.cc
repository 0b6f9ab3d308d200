// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/session.h"
#include "tools/cli/commands.h"

namespace panelcal {
namespace {

/// In the order of CalibrateOptions::What.
constexpr Expected<calibrate::Answer> (*kCalibrateCommands[])(const CalibrateOptions& options,
                                                              CommandContext& context) = {
    calibrate::spindle_camera,
    calibrate::camera,
    calibrate::table,
    calibrate::surface,
    calibrate::focus,
    calibrate::light,
    calibrate::settle};

}  // namespace

ExitCode run_command(const CalibrateOptions& options, CommandContext& context) {
  const auto answer = kCalibrateCommands[static_cast<std::size_t>(options.what)](options, context);
  context.console.end_progress();
  if (!answer) {
    context.console.print(answer.error());
    return exit_code(answer.error());
  }
  if (const auto written = context.output.write(answer->text); !written) {
    context.console.print(written.error());
    return exit_code(written.error());
  }
  return answer->code;
}

}  // namespace panelcal
