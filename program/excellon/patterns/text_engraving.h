// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/units.h"
#include <tl/expected.hpp>

namespace panelcal::excellon {

/// Between the holes of a character: 1.2 tool diameters; 0.0417 inch, which makes letters of a
/// quarter inch, if the diameter is unknown (or zero, which is how programs say so).
///
/// Source CNC-7 manual, Canned Text
double text_pitch_mm(std::optional<Length> tool_diameter);

/// Text as it is to be drilled: commas become spaces, each '*' becomes the operator's text `opid`
/// or, if that is empty, nothing at all. CharacterSet::Excellon4x7 has all characters of the
/// result.
///
/// A space is taken for a space too, though the manual writes it as a comma.
///
/// Fails  with the index in `text` of the first character that is not in the manual's set; the
///        index of the '*' if the character is in opid
/// Source CNC-7 manual, Canned Text
/// See    tests/program/excellon/patterns/text_engraving_test.cc
tl::expected<std::string, std::size_t> prepare_text(std::string_view text, std::string_view opid);

}  // namespace panelcal::excellon
