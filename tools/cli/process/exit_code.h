// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"

namespace panelcal {

/// The exit code of the process (docs: contract, "Exit codes").
enum class ExitCode : int {
  Done = 0,
  GateFailed = 1,    ///< the work was done, and a gate or check failed
  BadInput = 2,      ///< bad input or usage
  DeviceFailed = 3,  ///< a device or the environment failed, or panelcal itself
};

/// The worst of what the errors in the log call for: a broken environment over bad input over a
/// failed gate.
ExitCode exit_code(const DiagnosticLog& log);
ExitCode exit_code(const Diagnostic& diagnostic);

}  // namespace panelcal
