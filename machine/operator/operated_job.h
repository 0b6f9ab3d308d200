// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "machine/operator/desk.h"
#include "machine/operator/opened_program.h"
#include "machine/operator/station.h"

namespace panelcal::internal {

/// What a job is begun with.
struct JobOrder {
  std::string id;
  std::string program;         ///< its name
  std::string program_sha256;  ///< of what was checked; empty: whatever is there now
  bool is_resumed = false;     ///< the job's folder is there
  std::string who;
};

/// Measures, corrects and judges one job in the calling thread, from its folder to its verdict.
/// What becomes of it is on the desk and in the folder; nothing is thrown and nothing else
/// returned.
///
/// Precondition: settings.clock; the desk shows the job as measuring
void run_job(const StationSettings& settings, const JobOrder& order, Desk& desk);

/// The newest job that was cut off, as one that may be resumed; older ones become stopped.
std::optional<ScreenJob> interrupted_job(const StationSettings& settings);

/// The digest of machine.toml and of the calibrations that it names: measurements made with others
/// do not count.
std::string machine_digest(const MachineConfig& machine);

}  // namespace panelcal::internal
