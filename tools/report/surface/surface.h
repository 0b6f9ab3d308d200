// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal::report {

/// Every probed place with its heights above the table, one column a Z axis, and how far the first
/// is from where the surface was expected; nodes of a grid that were filled; and what depths took
/// from a map made before. Empty for a program that probes nothing and follows no map.
///
/// In     use: of that map, in words; empty: there is none
std::string surface_section(const Survey& survey, const std::string& use);

}  // namespace panelcal::report
