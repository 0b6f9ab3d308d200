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
  StatedFormat stated;                     ///< the number format, by the header and outside
  StatedFormat whole;                      ///< and by the body before its first coordinate
  bool has_dimension = false;              ///< numbers that the unit measures stand in the header
  bool has_bare_dimension = false;         ///< one of them has no decimal point
  ProgramSet set = ProgramSet::FormatTwo;  ///< FMAT
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

  /// Of its own numbers.
  const NumberFormat& format() const { return stated.format(); }
  /// The statements that decide how the body's numbers are read, for people; empty: there is none.
  std::string format_evidence() const { return whole.evidence(); }
  /// Outputs state one unit in their header: that of the body where only the body states it.
  NumberFormat number_format() const override { return of_outputs().format(); }
  /// Not digits that a unit of the program takes from elsewhere, or that only its numbers show.
  bool declares_digits() const override {
    const StatedFormat& of = of_outputs();
    return of.states_digits() ||
           (!of.states_unit() && of.knows_digits() && of.format().states_digits);
  }
  std::string number_summary() const override { return whole.format().summary(); }
  std::string reading() const override;

 private:
  const StatedFormat& of_outputs() const {
    return stated.states_unit() || has_dimension ? stated : whole;
  }
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
