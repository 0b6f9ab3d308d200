// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "program/model/operation.h"
#include "program/model/program_head.h"
#include "program/sieb_meyer/text/numbers.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"

namespace panelcal {
struct Program;
}  // namespace panelcal

namespace panelcal::sieb_meyer {

/// The formats that outputs in the other language take a program of this one for.
inline constexpr NumberFormat kMetricFormat = {.unit = LengthUnit::Millimeter,
                                               .zeros = Zeros::LeadingKept,
                                               .integer_digits = 3,
                                               .decimal_digits = 3};
inline constexpr NumberFormat kInchFormat = {.unit = LengthUnit::Inch,
                                             .zeros = Zeros::LeadingKept,
                                             .integer_digits = 2,
                                             .decimal_digits = 4};

/// A file as its marks divide it: comments, %% and the format, program lines, $ and the tool table.
struct FileLayout : ProgramHead {
  FileFormat format = FileFormat::F5000;
  ProgramFormat numbers;        ///< of that format, but for what the control's setting changes
  std::string setting;          ///< the digits behind %%, as FP has them too; may be empty
  std::string format_evidence;  ///< its source beside the %%, for people; empty: none
  SubprogramNumbers subprograms = SubprogramNumbers::OfProgram;
  int head_line = 0;         ///< of the %%
  LinePlace body;            ///< behind the %%
  std::size_t body_end = 0;  ///< place of the $, or the end of the text
  /// Tools of format 1000 with six empty values: zero, if the program takes them.
  std::map<int, Tool> empty_tools;

  /// A tool that the program takes, with its data in the table; its number alone if it has none.
  Tool taken_tool(int number) const;
  NumberFormat number_format() const override {
    return numbers.unit == LengthUnit::Inch ? kInchFormat : kMetricFormat;
  }
  std::string number_summary() const override { return summary(numbers); }
  std::string reading() const override;
};

/// A line of two percent signs, with or without a format, comes before anything that opens an
/// Excellon program.
bool is_program(std::string_view bytes);

/// Finds the parts of a file and reads the tool table. In the formats 3000 and 5000 a letter
/// without a number sets its datum to zero, and the last one of a tool holds; format 1000 has six
/// values for each of 15 tools in a fixed order, 91 dollar signs in all; its magazines have the
/// tools' numbers. A datum of zero is no datum, but Tool::zeroed.
///
/// Fails  into the log: command-format, format-ambiguous, end-missing (no table),
///        tool-table-invalid; warns text-after-end, format-overridden, format-assumed
/// Source SIEB & MEYER CNC 8x.00 Command Set, appendix A
/// See    tests/program/sieb_meyer/text/file_layout_test.cc
FileLayout read_layout(const SourceText& source,
                       DiagnosticLog& log,
                       const ReadOptions& reading = {});

/// The layout of a program in this language.
///
/// Precondition: load_program() has read it, and its dialect is SiebMeyer
const FileLayout& layout_of(const Program& program);

}  // namespace panelcal::sieb_meyer
