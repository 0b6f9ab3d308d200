// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/history/diff.h"

namespace panelcal::history {

/// Arrows from where places of the job are to where they would be, magnified, with their scale, the
/// job's outline and its targets: one SVG that needs no other file.
std::string job_shift_svg(const JobShift& shift, const JobShiftFacts& facts);

}  // namespace panelcal::history
