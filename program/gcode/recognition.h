// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "program/text/source_text.h"

namespace panelcal::gcode {

/// The first line that shows that a text is G-code, the language of a machine's control: it has a
/// word that no drill program has (G21, G54, G94 ...), and a line moves Z.
///
/// In     bytes: a text that does not begin with %%
/// Out    empty: it may be a drill program. A text with an M48 is.
/// Cost   a look at 2,000 lines at most
/// See    tests/program/gcode/recognition_test.cc
std::optional<SourceLine> line_of_gcode(std::string_view bytes);

}  // namespace panelcal::gcode
