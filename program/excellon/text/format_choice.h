// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "program/excellon/text/body_unit.h"
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
  std::optional<BodyUnit> body;  ///< looked for where the header states not all of unit and zeros
  const ReadOptions& reading;
};

/// The parts of its format that a program's numbers decide.
struct FormatChoice {
  PartialFormat numbers;  ///< empty: none
  bool is_open = false;   ///< nothing decides: the program cannot be walked through
};

/// Finds the one format that the numbers can be meant in of a program that does not state its unit
/// or its zeros; docs/conventions.md, "Number format not stated", has what rules a reading out.
///
/// Out    the header is to be read again, with `numbers`; absent: it is as it has to be
/// Fails  into the log: format-ambiguous, with the extents of two readings; the fault of a file
///        beside the program that would have decided; warns format-assumed, also of digits that a
///        unit takes from outside of the program
/// Source CNC-7 manual, Leading and Trailing Zeros: which zeros a writer leaves off in each mode;
///        Inch vs. Metric: the digits that a control has
std::optional<FormatChoice> choose_format(const DraftedProgram& program, DiagnosticLog& log);

}  // namespace panelcal::excellon
