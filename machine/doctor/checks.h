// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "machine/config/machine_config.h"
#include "machine/doctor/examination.h"
#include "machine/doctor/finding.h"

// The parts of examine(), each of which adds its lines.
namespace panelcal::doctor {

/// Lines of machine.toml whose comment begins with "assumed; " and says what measures them.
void check_assumptions(std::string_view machine_toml, Findings& findings);

/// Calibrations of the camera, the offset and the table.
void check_calibrations(const MachineConfig& config,
                        std::chrono::sys_seconds now,
                        Findings& findings);

/// The error that every hole has, however good its targets are, against [tolerance].
///
/// In     config: with the offset's drift until now
void check_error_budget(const MachineConfig& config, Findings& findings);

/// Programs that commands of machine.toml name.
void check_programs(const MachineConfig& config, Findings& findings);

/// The ledger, the reports and the disk.
void check_files(const MachineConfig& config, Findings& findings);

/// The camera, the control and the probe.
void check_devices(const MachineConfig& config, const Examination& examination, Findings& findings);

/// The night that comes, by a dry run of [nightly].
void check_night(const MachineConfig& config, const Examination& examination, Findings& findings);

}  // namespace panelcal::doctor
