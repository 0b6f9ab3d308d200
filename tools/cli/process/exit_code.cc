// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/process/exit_code.h"

#include <algorithm>

namespace panelcal {

ExitCode exit_code(const Diagnostic& diagnostic) {
  if (diagnostic.severity() != Severity::Error) return ExitCode::Done;
  switch (info(diagnostic.code).fault) {
    case Fault::Gate:
      return ExitCode::GateFailed;
    case Fault::Input:
      return ExitCode::BadInput;
    case Fault::Device:
    case Fault::Internal:
      return ExitCode::DeviceFailed;
  }
  return ExitCode::DeviceFailed;
}

ExitCode exit_code(const DiagnosticLog& log) {
  ExitCode worst = ExitCode::Done;
  for (const Diagnostic& diagnostic : log.kept()) {
    worst = std::max(worst, exit_code(diagnostic));
  }
  return worst;
}

}  // namespace panelcal
