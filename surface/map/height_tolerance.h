// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "surface/control/reference_plane.h"
#include <tl/expected.hpp>

namespace panelcal {

/// Compares a probed height with its reference, each Z axis for itself.
///
/// In     command: who set the tolerance (BOTT, TOPT or MAPT), as the text names it
///        measured: one height per Z axis
///        reference, tolerance: one value per Z axis, or a single one for all of them
/// Fails  the deviation, up or down, is above the tolerance; the text names the worst Z axis,
///        counted from 0 as in probe files. Also if the numbers of Z axes do not agree, if there
///        have no surface, and where a number is not finite.
/// Source SIEB & MEYER CNC 8x.00, G78 and G79
/// See    tests/surface/map/height_tolerance_test.cc
tl::expected<void, std::string> check_height(std::string_view command,
                                             std::span<const HeightEstimate> measured,
                                             std::span<const Length> reference,
                                             std::span<const Length> tolerance);

}  // namespace panelcal
