// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "program/excellon/text/body_start.h"
#include "program/excellon/text/header.h"
#include "program/text/number_format.h"
#include "program/walk/options.h"

namespace panelcal::excellon {

/// Texts of the stored patterns that a program calls, in the manual's characters.
using PatternTexts = std::function<std::vector<std::string>(std::string_view program)>;

/// A program whose header has been read once, with what is stated outside of the program.
struct DraftedProgram {
  const std::string& file;
  std::string_view text;
  const PatternTexts& read_patterns;  ///< asked only where numbers decide; may be empty
  const Header& header;
  const BodyStart& body;
  const ReadOptions& reading;
};

/// The parts of its format that a program's numbers decide.
struct FormatChoice {
  PartialFormat numbers;  ///< empty: none
  bool is_open = false;   ///< nothing decides: the program cannot be walked through
};

/// Finds the one format that the numbers can be meant in of a program that does not state its unit
/// or its zeros; docs/conventions.md, "Number format", has what rules a reading out.
///
/// Out    with `numbers` the header is to be read again
/// Fails  into the log: format-ambiguous, with the extents of two readings; what is wrong with a
///        file beside the program that would decide; coordinates that only such a file says are
///        steps; warns format-assumed, also of digits that a
///        unit takes from outside of the program
/// Source CNC-7 manual, Leading and Trailing Zeros: which zeros a writer leaves off in each mode;
///        Inch vs. Metric: the digits that a control has
FormatChoice choose_format(const DraftedProgram& program, DiagnosticLog& log);

}  // namespace panelcal::excellon
