// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "program/sieb_meyer/text/numbers.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"

namespace panelcal::sieb_meyer {

/// The statement of a line that begins a program: two percent signs and perhaps four digits.
struct FormatMark {
  FileFormat file = FileFormat::F5000;
  std::string_view setting;  ///< the digits; empty: the control's default format
  /// One of xx01 to xx10: the commands of its first digit's format, in other numbers.
  bool is_special = false;
};

/// Absent for a text that no format has.
std::optional<FormatMark> parse_format_mark(std::string_view text);

/// The number format of a program, and its source beside the mark, for people.
struct FormatChoice {
  ProgramFormat format;
  std::string evidence;  ///< empty: the mark alone
  /// Open where the digits behind %% and the control's setting differ.
  SubprogramNumbers subprograms = SubprogramNumbers::OfProgram;
};

/// Decides how a program's numbers are read.
///
/// "When the program is loaded another format than the default format is used": the digits behind
/// %% rule over the control's setting, [program] units, zeros and digits. So 1000, 3000 and 5000
/// are what the manual's tables say; %% alone leaves the numbers to the setting, if that has a
/// unit, zeros and digits: what is stated for programs in the other language is no setting of this
/// control. The formats xx01 to xx10, "special cases" without a description, are read if the
/// setting and
/// --format have all three. --format rules over all.
///
/// In     line, column: of the mark; text: of that line
/// Fails  into the reporter: command-format (xx01 to xx10 without a unit, zeros or digits);
///        format-ambiguous (format 1000 in inch without digits: it has no decimal points; leading
///        zeros without digits; --format inch where [program] has leading zeros in inch; %% alone
///        where [program] has inch without zeros or digits); warns format-overridden,
///        format-assumed
/// Source SIEB & MEYER CNC 8x.00 Command Set, 1 Format settings; A.1; A.5.1 to A.7.1; B
/// See    tests/program/sieb_meyer/text/format_setting_test.cc
FormatChoice choose_format(const FormatMark& mark,
                           std::string_view text,
                           int line,
                           int column,
                           const ReadOptions& reading,
                           const Reporter& reporter);

}  // namespace panelcal::sieb_meyer
