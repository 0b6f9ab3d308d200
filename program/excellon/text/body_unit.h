// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "program/excellon/text/lexer.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"

namespace panelcal::excellon {

/// The unit as a body states it, by INCH, METRIC, M71 or M72.
struct BodyUnit {
  int line = 0;
  std::string_view text;  ///< of the line, without blanks at either end
  PartialFormat format;   ///< the unit, and perhaps zeros
};

/// Looks on from `body` for a unit before the first coordinate, and before settings with lengths,
/// which would mean something else in an output that states it in its header.
///
/// Source CNC-7 manual, Metric Measuring Mode; Inch Measuring Mode
/// See    tests/program/excellon/text/header_test.cc
std::optional<BodyUnit> find_body_unit(LineCursor body, ProgramSet set);

}  // namespace panelcal::excellon
