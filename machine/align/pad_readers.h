// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/align/pad.h"

// Not installed: the files that pads come from.
namespace panelcal::internal {

/// A pad as a file has it.
struct FoundPad {
  Pad pad;                         ///< without a vision tool, unless the file names one
  std::optional<Length> diameter;  ///< of a round one
};

struct FoundPads {
  std::vector<FoundPad> pads;
  std::string words;  ///< "flashes FiducialPad,Global"
};

/// A number that the text is from end to end; empty for any other text.
std::optional<double> decimal_of(std::string_view text);

/// True for the text of a list: numbers, commas, semicolons.
bool is_pad_list(std::string_view text);
/// Fails  usage
Expected<FoundPads> pads_of_list(std::string_view text);

bool is_gerber(std::string_view bytes);
/// The flashes of a Gerber file (RX-274X) that are fiducials by their aperture's attribute; without
/// any such attribute round ones of a stated diameter.
///
/// Reads what decides where a flash lies: format, unit, apertures with their attributes, modal
/// coordinates. Step and repeat, block apertures and image transformations, which would move
/// flashes, are refused.
///
/// In     diameter: of flashes without an attribute; those within 1 % of it count
/// Fails  argument-invalid; not-supported; number-malformed; end-missing; usage (no such flash)
/// Source Gerber Layer Format Specification 2022.02, sections 4 and 5
/// See    tests/machine/align/gerber_test.cc
Expected<FoundPads> pads_of_gerber(std::string_view bytes,
                                   const std::string& file,
                                   const std::optional<Length>& diameter);

bool is_placement(std::string_view bytes);
/// The rows of a placement file (KiCad's .pos, or CSV with a header) whose reference begins with
/// FID.
///
/// Fails  argument-invalid; number-malformed; usage (no such row)
/// See    tests/machine/align/placement_test.cc
Expected<FoundPads> pads_of_placement(std::string_view bytes, const std::string& file);

}  // namespace panelcal::internal
