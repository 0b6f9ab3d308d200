// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal::report {

/// Every calibration that the program asked for while it was measured, and what it found. Empty for
/// a program without one.
std::string calibrations_section(const Survey& survey);

}  // namespace panelcal::report
