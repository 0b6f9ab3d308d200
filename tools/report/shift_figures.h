// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tools/figures/svg.h"
#include "tools/report/input/facts.h"
#include "tools/report/input/input.h"

namespace panelcal::report {

/// Two pictures of where the panel went: arrows from nominal to corrected at holes on a coarse grid
/// (from nominal to measured at the targets while nothing is corrected), with the shift of the
/// middle taken out, then with the rotation taken out as well. Empty where nothing moved.
std::string shift_figures(const ReportInput& input,
                          std::span<const TargetFact> facts,
                          const Extent& extent);

}  // namespace panelcal::report
