// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/excellon/text/header.h"
#include "program/text/number_format.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// The number format that a header is read with as long as it states nothing else.
struct FormatStart {
  NumberFormat format;
  bool knows_unit = false;
  bool knows_zeros = false;
  bool is_open = false;  ///< format-ambiguous
  std::string evidence;  ///< its source, for people; empty: nothing states it
  std::string assumed;   ///< the reason against others, where nothing states it
};

/// Texts of the stored patterns that a program calls, in the manual's characters.
using PatternTexts = std::function<std::vector<std::string>(std::string_view program)>;

/// The one of --format and the control's last setting.
FormatStart stated_start(const ReadOptions& reading);

/// Finds the one format that the numbers can be meant in of a program that does not state its unit
/// or its zeros; docs/conventions.md, "Number format not stated", has what rules a reading out.
///
/// In     read_patterns: asked only where numbers decide; may be empty
///        draft: the header as read with `start`; what it states is known
/// Out    `start` with the one reading that is left, and a warning format-assumed with the reason;
///        absent: the draft is as it has to be
/// Fails  into the log: format-ambiguous, with the extents of two readings
/// Source CNC-7 manual, Leading and Trailing Zeros: which zeros a writer leaves off in each mode
std::optional<FormatStart> choose_format(std::string_view program,
                                         const PatternTexts& read_patterns,
                                         const Header& draft,
                                         FormatStart start,
                                         const ReadOptions& reading,
                                         const Reporter& reporter);

}  // namespace panelcal::excellon
