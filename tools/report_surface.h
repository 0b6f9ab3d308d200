// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "panelcal/program/survey.h"

namespace panelcal::report {

/// Every probed place with its heights above the table, one column a Z axis, and how far the first
/// is from where the surface was expected. Empty for a program that probes nothing.
std::string surface_section(const Survey& survey);

}  // namespace panelcal::report
