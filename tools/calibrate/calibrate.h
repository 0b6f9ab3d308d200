// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/sources/device_set.h"
#include "tools/cli/commands.h"

// The commands `panelcal calibrate WHAT`.
namespace panelcal::calibrate {

/// The text for standard output, and whether the result may be used.
struct Answer {
  std::string text;
  ExitCode code = ExitCode::Done;
};

/// The devices of SOURCE.
///
/// Fails  usage (no SOURCE); what DeviceSet reports
Expected<DeviceSet> open_devices(const CalibrateOptions& options, const MachineConfig& config);

/// Keeps other runs away from the machine until `lock` ends; before its devices are opened. A
/// machine without a ledger has no nightly run.
///
/// Fails  ledger-busy; device-write; usage (--clock)
Expected<void> lock_machine(const CalibrateOptions& options,
                            const MachineConfig& config,
                            std::optional<NightLock>& lock);

/// The time of --clock, or now.
///
/// Fails  usage
Expected<std::chrono::sys_seconds> time_of(const CalibrateOptions& options);

Expected<Answer> spindle_camera(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> camera(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> table(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> surface(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> focus(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> light(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> settle(const CalibrateOptions& options, CommandContext& context);

}  // namespace panelcal::calibrate
