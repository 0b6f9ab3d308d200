// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/report/input/input.h"

namespace panelcal::report {

/// The section "Tolerance": how sure every tool's places are, as a table and as a picture of the
/// risks. Empty without [tolerance].
std::string verdict_section(const ReportInput& input);

}  // namespace panelcal::report
