// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/report/input/input.h"

namespace panelcal::report {

/// Every series as one line in words, with its numbers and gates folded below it; panel fits and
/// refused ones are unfolded. Many boards fold into one line of ranges.
std::string fits_section(const ReportInput& input);

}  // namespace panelcal::report
