// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/excellon/text/stated_format.h"
#include "program/model/operation.h"
#include "program/model/program_head.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"

namespace panelcal {
struct Program;
}  // namespace panelcal

namespace panelcal::excellon {

/// A machine setting of the header, passed on in order.
struct HeaderSetting {
  int line = 0;
  std::string text;
};

/// The head of a program, before its body.
struct Header : ProgramHead {
  NumberFormat format;              ///< that of `stated`
  StatedFormat stated;              ///< its parts with their sources
  bool has_dimension = false;       ///< numbers that the unit measures stand in the header
  bool has_bare_dimension = false;  ///< one of them has no decimal point
  /// With the unit that only the body states, before its first coordinate: that of outputs.
  std::optional<NumberFormat> body_format;
  std::string format_evidence;                ///< its sources, for people; empty: none
  ProgramSet set = ProgramSet::FormatTwo;     ///< FMAT
  std::map<int, Length> compensation_values;  ///< CP: diameter by compensation index
  std::vector<HeaderSetting> settings;
  bool incremental = false;                                        ///< ICI,ON
  bool states_incremental = false;                                 ///< it is stated, on or off
  Displacement<frame::Programmed> text_offset;                     ///< CAN_TEXT_OFF
  std::optional<Displacement<frame::Programmed>> zero_set;         ///< Z
  std::optional<Displacement<frame::Programmed>> zero_correction;  ///< ZC
  int end_line = 0;           ///< of % or M95; 0: there is no header
  bool stops_at_end = false;  ///< % rather than M95
  LinePlace body;             ///< the first line behind the header
  /// Options by header word, as stated: in the body another one would not be used.
  std::map<std::string, std::string, std::less<>> options;
  int zero_line = 0;           ///< of Z
  bool calls_patterns = true;  ///< false: the text has no M99
  bool is_refused = false;     ///< not-a-program, format-ambiguous: nothing can be walked through
  std::string respelled;  ///< the text in the manual's characters; empty: the source has no others

  NumberFormat number_format() const override { return body_format.value_or(format); }
  std::string number_summary() const override { return number_format().summary(); }
};

/// The header of a program in this language.
///
/// Precondition: load_program() has read it, and its dialect is Excellon
const Header& header_of(const Program& program);

/// The text of a program in this language, in the manual's characters.
///
/// Precondition: as header_of()
std::string_view text_of(const Program& program);

}  // namespace panelcal::excellon
