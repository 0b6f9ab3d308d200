// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "machine/config/machine_config.h"
#include "program/walk/walk.h"
#include "tools/cli/console.h"
#include "tools/cli/options.h"
#include "tools/report/views.h"

namespace panelcal {

/// The measuring half of a run.
struct MeasuringResult {
  Survey survey;
  std::string source;                             ///< where measurements came from, in words
  std::map<std::int64_t, std::string> crops_png;  ///< by seq; empty unless wanted
  std::map<std::int64_t, std::vector<ReportView>> views;  ///< the same
};

/// Surveys the program with the SOURCE that the options name, and with their source of probe
/// readings, showing progress.
///
/// In     nominal: what a perfect panel would be asked
/// Fails  usage (a program with targets and no SOURCE, or with probes and no source of readings);
///        what making the sources reports. What the survey finds goes into the log.
Expected<MeasuringResult> measure_program(const RunOptions& options,
                                          const MachineConfig& config,
                                          const Program& program,
                                          const Survey& nominal,
                                          Console& console,
                                          DiagnosticLog& log);

/// The fits in a few lines for people.
std::string fits_summary(const Survey& survey);

}  // namespace panelcal
