// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/gcode/leveller.h"
#include "tools/cli/options/surface_options.h"
#include "tools/cli/provenance.h"

namespace panelcal::surface {

/// Those of the command line.
LevelOptions level_options(const SurfaceOptions& options);

/// The changes by levelling, in lines for people.
std::string level_text(const LevelFigures& figures);

/// Marks a program that was levelled.
inline constexpr std::string_view kLevelledBy = "(levelled by panelcal";

/// Comments that say what made it, in front of a G-code program, but behind a % that has to be
/// first.
///
/// In     mark: kLevelledBy, or the like
std::string with_provenance(std::string text, std::string_view mark, const Provenance& provenance);

}  // namespace panelcal::surface
