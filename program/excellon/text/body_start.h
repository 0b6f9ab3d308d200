// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/excellon/text/stated_format.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"

namespace panelcal::excellon {

/// INCH, METRIC, M71 or M72 in a body.
struct BodyUnit {
  int line = 0;
  std::string_view text;  ///< of the line, without blanks at either end
  StatedFormat::Form form = StatedFormat::Form::Code;
  PartialFormat format;  ///< the unit, and perhaps zeros
};

/// The statements of a body about all of its coordinates.
struct BodyStart {
  std::vector<BodyUnit> units;  ///< in their order
  bool states_steps = false;    ///< G90, G91 or ICI: whether coordinates are steps
};

/// Looks on from `body`, up to the first coordinate, or to settings with lengths, which would mean
/// something else in an output that states its unit in its header.
///
/// Source CNC-7 manual, Metric Measuring Mode; Inch Measuring Mode
/// See    tests/program/excellon/text/header_test.cc
BodyStart read_body_start(LineCursor body, ProgramSet set);

}  // namespace panelcal::excellon
