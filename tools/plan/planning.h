// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "machine/config/settings/machine.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "tools/plan/design/plan.h"

namespace panelcal::plan {

/// The program whose targets are planned, and what is known of them.
struct PlanningTerms {
  std::string command = "panelcal plan";  ///< as diagnostics name who asks
  /// Reads the program, as read_program(); what is wrong goes into the log.
  std::function<std::optional<Program>(const ReadOptions& reading, DiagnosticLog& log)> read;
  WalkTerms walk;
  std::string measurements;  ///< of an earlier job, for the noise of its targets; may be empty
  std::optional<double> fiducial_sigma_um;  ///< noise of a target's picture along each axis
  std::size_t n_added = 1;                  ///< further targets to propose together
};

/// A program that was walked through once on the perfect panel, ready to be planned.
struct Planning {
  MachineConfig machine;  ///< as the plan's walks have it
  CheckedProgram checked;
  std::vector<PanelModel> programmed;  ///< by series
  PlanRequest request;
  std::string time;  ///< on the wall

  Plan make() const;
};

/// Reads the machine's terms, the program and the noise of its targets, in this order.
///
/// If only the design of a series is at fault, another model that any target determines stands for
/// it, so that there are holes to speak of.
///
/// Out    absent if the log has an error
std::optional<Planning> prepare_plan(const PlanningTerms& terms,
                                     MachineConfig machine,
                                     DiagnosticLog& log);

}  // namespace panelcal::plan
