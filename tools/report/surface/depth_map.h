// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/judge/depth_verdict.h"

namespace panelcal::report {

/// Styles that the pictures of surfaces need; empty where there is none to draw.
std::string_view depth_map_style(const DepthVerdict* verdict);

/// The surface that depths are judged by, one picture a Z axis, with each tool's worst place; empty
/// where it is unknown.
std::string depth_map_figures(const DepthVerdict& verdict);

}  // namespace panelcal::report
