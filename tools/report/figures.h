// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tools/report/input/facts.h"
#include "tools/report/input/input.h"

namespace panelcal::report {

/// The panel to scale: holes by tool, fiducials, residual arrows; beside it where the panel went,
/// first with the shift of its middle taken out (rotation and stretch show), then with the rotation
/// taken out as well (stretch and what single boards did). Every picture states its magnification.
std::string panel_figures(const ReportInput& input, std::span<const TargetFact> facts);

}  // namespace panelcal::report
