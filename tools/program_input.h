// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/program/walk.h"

namespace panelcal {

/// A program that was walked through once on a perfect panel, so that its mistakes are known before
/// anything moves.
struct CheckedProgram {
  Program program;
  Survey nominal_survey;  ///< what it would measure
};

/// Reads PROGRAM (`-` is standard input) and the stored patterns it names, which are looked for
/// beside it and then where `reading` says; checks it. Gates are left out, since a perfect panel
/// breaks no limit. Problems go into the log; absent if it could not even be read.
std::optional<CheckedProgram> read_and_check(const std::string& path,
                                             ReadOptions reading,
                                             const WalkOptions& options,
                                             DiagnosticLog& log);

/// Passes the whole job on the perfect panel to `sink`. Precondition: no errors in the check.
void execute_nominal(const CheckedProgram& checked,
                     const WalkOptions& options,
                     OperationSink& sink,
                     DiagnosticLog& log);

}  // namespace panelcal
