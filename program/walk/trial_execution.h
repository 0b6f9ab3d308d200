// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"

namespace panelcal {

/// A check that executes as well. It is over where a section is repeated, whose copies a check only
/// counts, and, if so wanted, where the program asks for what only a machine can answer: the check
/// goes on alone.
struct TrialExecution {
  bool ends_when_asked = true;
  DiagnosticLog working_log;  ///< problems that only a working walk finds
  bool is_asked = false;      ///< by the program: the sources set it
  bool is_repeated = false;   ///< a section
  bool is_over() const { return is_repeated || (is_asked && ends_when_asked); }
};

}  // namespace panelcal
