// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "program/text/number_format.h"

namespace panelcal {

// Facts for writers of another language about settings, which are passed on as written.

/// The word of an Excellon setting: PCKPARAM of `PCKPARAM,1`.
std::string_view setting_key(std::string_view text);

/// True for an order to the vision system that no walk obeys, so that nothing of it is in what is
/// executed: M75, and the `$uvis` switches auto, entry and box.
bool is_left_to_vision(std::string_view text);

/// True for a setting of the notation of numbers and modes in Excellon: a writer has its own.
bool is_spelling(std::string_view key);

/// Of Excellon settings: ZC is a part of work zero; DN and Z are depths.
bool decides_places(std::string_view key);

/// Of SIEB & MEYER's M49: what the walk has obeyed, or the writer states itself.
bool is_obeyed(std::string_view command);

/// True for a CNC command (M49, without it) that states what a control begins with: how slots are
/// nibbled.
///
/// In     unit: of its numbers
bool is_initial(std::string_view command, LengthUnit unit);

}  // namespace panelcal
