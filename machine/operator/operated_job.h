// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "machine/operator/desk.h"
#include "machine/operator/opened_program.h"
#include "machine/operator/settings.h"

namespace panelcal::internal {

/// The order to begin a job.
struct JobOrder {
  std::string id;
  std::string program;         ///< its name
  std::string program_sha256;  ///< of what was checked; empty: whatever is there now
  bool is_resumed = false;     ///< the job's folder is there
  std::string who;
};

/// Measures, corrects and judges one job in the calling thread, from its folder to its verdict.
/// Its outcome is on the desk and in the folder; nothing is thrown, nothing else returned.
///
/// Precondition: settings.clock; the desk shows the job as measuring
void run_job(const StationSettings& settings, const JobOrder& order, Desk& desk);

/// The newest job, unless it was closed: one that was cut off may be resumed, one that has ended is
/// as it was. Older ones that were cut off become stopped.
std::optional<ScreenJob> last_job(const StationSettings& settings);

/// The words of a verdict, with the name that the corrected program was given last.
std::string with_output_name(std::string verdict, const std::vector<std::string>& outputs);

/// The digest of machine.toml and of the calibrations that it names: measurements made with others
/// do not count.
std::string machine_digest(const MachineConfig& machine);

}  // namespace panelcal::internal
