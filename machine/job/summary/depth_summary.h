// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "program/judge/depth_verdict.h"

namespace panelcal {

/// "30.0 / 50.0": a tool's tolerance, shallow and deep, um.
std::string depth_tolerance_text(const DepthTolerance& tolerance);

/// The parts of the surface's map and its outliers, one line each; or why there is no map.
std::vector<std::string> surface_lines(const DepthVerdict& verdict);

/// A table with one row a tool, and the verdict in one line behind it.
std::string depth_summary(const DepthVerdict& verdict);

}  // namespace panelcal
