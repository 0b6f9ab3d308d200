// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/interruption.h"
#include "tools/calibrate/calibrate.h"
#include "tools/cli/commands.h"

namespace panelcal {
namespace calibrate {

Expected<DeviceSet> open_devices(const CalibrateOptions& options, const MachineConfig& config) {
  if (options.machine_driver == "sim") return DeviceSet::simulated(config);
  if (!options.camera.empty()) {
    heed_interruptions();
    return DeviceSet::live(config, options.camera);
  }
  return failure({Code::Usage,
                  {"panelcal calibrate", 0, 0},
                  "there is no SOURCE to calibrate with",
                  "--camera or --machine-driver"});
}

Expected<void> lock_machine(const CalibrateOptions& options,
                            const MachineConfig& config,
                            std::optional<NightLock>& lock) {
  if (config.ledger_file.empty()) return {};
  PANELCAL_TRY(const auto now, time_of(options));
  PANELCAL_TRY(NightLock taken, NightLock::take(config.ledger_file, now));
  lock.emplace(std::move(taken));
  return {};
}

Expected<std::chrono::sys_seconds> time_of(const CalibrateOptions& options) {
  if (options.clock.empty()) return system_clock()();
  if (const auto time = from_iso_8601(options.clock)) return *time;
  return failure({Code::Usage,
                  {"panelcal calibrate", 0, 0},
                  "--clock " + quoted(options.clock),
                  "a date and a time in UTC, such as 2026-11-21T02:00:00Z"});
}

namespace {

Expected<Answer> calibrate_answer(const CalibrateOptions& options, CommandContext& context) {
  using What = CalibrateOptions::What;
  switch (options.what) {
    case What::SpindleCamera:
      return spindle_camera(options, context);
    case What::Camera:
      return camera(options, context);
    case What::Table:
      return table(options, context);
    case What::Surface:
      return surface(options, context);
    case What::Focus:
      return focus(options, context);
    case What::Light:
      return light(options, context);
    case What::Settle:
      return settle(options, context);
  }
  return Answer();
}

}  // namespace
}  // namespace calibrate

ExitCode run_command(const CalibrateOptions& options, CommandContext& context) {
  const Expected<calibrate::Answer> answer = calibrate::calibrate_answer(options, context);
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
