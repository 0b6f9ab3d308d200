// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/judge/depth_verdict.h"

namespace panelcal::report {

/// The tile of the first screen; empty where no depth was judged.
std::string depth_tile(const DepthVerdict* verdict);

/// The section "Depth": how sure every tool's depths are. Empty for a null verdict.
std::string depth_section(const DepthVerdict* verdict);

}  // namespace panelcal::report
